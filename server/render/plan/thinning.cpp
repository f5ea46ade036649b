// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/thinning.h"

#include <algorithm>
#include <cmath>

#include "server/render/plan/hidden_area.h"

namespace mote::render {
namespace {

constexpr double lightest = -24.0;  // weights are told between 2^lightest and 2^-lightest
constexpr double places = 8.0;      // of the table, to twice the weight

double rounded(double value) {
    constexpr double steps = 128.0;  // to twice as much
    return std::exp2(std::round(steps * std::log2(value)) / steps);
}

}  // namespace

Thinning Thinning::roughly(const Thinning& exactly) {
    return {rounded(exactly.tau), rounded(exactly.rest), rounded(exactly.here), exactly.pixels, exactly.most};
}

ThinnedWeights::ThinnedWeights(const Thinning& thinning, double share) {
    const double square = thinning.pixels * thinning.pixels;
    // Of the points of the mean weight no more are drawn than were asked for.
    const double greatest = std::max(hiddenBy(thinning.most, thinning.here),
                                     square * hiddenBy(thinning.tau, thinning.rest) / share);
    for (double place = 0.0; place <= -2.0 * lightest * places; place += 1.0) {
        const double tau = thinning.tau * std::exp2(lightest + place / places);
        const double wanted = square * hiddenBy(tau, thinning.rest);
        const double drawn = std::clamp(wanted / greatest, share, 1.0);
        shares_.push_back(drawn);
        weights_.push_back(std::log2(tauHiding(wanted / drawn, thinning.here, std::max(thinning.most, tau))));
    }
    const double mean = between(weights_, 1.0);
    for (double& weight : weights_) weight -= mean;
}

double ThinnedWeights::between(const std::vector<double>& table, double weight) {
    const double last = static_cast<double>(table.size() - 1);
    const double at = std::clamp((std::log2(weight) - lightest) * places, 0.0, last);
    const auto below = static_cast<std::size_t>(std::min(at, last - 1.0));
    const double share = at - static_cast<double>(below);
    return (1.0 - share) * table[below] + share * table[below + 1];
}

double ThinnedWeights::share(double weight) const {
    return between(shares_, weight);
}

double ThinnedWeights::weightHere(double weight) const {
    return std::exp2(between(weights_, weight));
}

}  // namespace mote::render
