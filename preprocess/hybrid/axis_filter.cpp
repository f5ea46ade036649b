// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/hybrid/axis_filter.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "storage/hybrid/grid_axis.h"

namespace mote::prep {
namespace {

double keys(double x) {
    x = std::abs(x);
    if (x < 1.0) return (1.5 * x - 2.5) * x * x + 1.0;
    if (x < 2.0) return ((-0.5 * x + 2.5) * x - 4.0) * x + 2.0;
    return 0.0;
}

}  // namespace

AxisFilter::AxisFilter(LowFilter filter, std::uint32_t samples, std::uint32_t low) {
    const double scale = static_cast<double>(samples) / low;
    const bool box = filter == LowFilter::box;
    for (std::uint32_t j = 0; j < low; ++j) {
        const double centre = storage::placeIn(j, low, samples);
        const double reach = box ? scale / 2 + 0.5 : 2 * scale;
        const auto first = static_cast<std::uint32_t>(std::max(0.0, std::floor(centre - reach) + 1.0));
        const auto last =
            static_cast<std::uint32_t>(std::min(samples - 1.0, std::ceil(centre + reach) - 1.0));
        std::vector<double> weights;
        for (auto i = first; i <= last; ++i) {
            const double overlap =
                std::min(i + 0.5, centre + scale / 2) - std::max(i - 0.5, centre - scale / 2);
            weights.push_back(box ? std::max(0.0, overlap) : keys((i - centre) / scale));
        }
        const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
        taps_.push_back({first, static_cast<std::uint32_t>(weights.size()), weights_.size()});
        for (const double weight : weights) weights_.push_back(static_cast<float>(weight / sum));
    }
}

}  // namespace mote::prep
