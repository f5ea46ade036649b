// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/pixel_fragments.h"

#include <algorithm>

namespace mote::render {
namespace {

// What is behind less is not seen, as of all that rays meet.
constexpr double leftBehind = 5e-5;

}  // namespace

void PixelFragments::take(std::uint32_t column, std::uint32_t row, Fragments& fragments) {
    std::stable_sort(hits_.begin(), hits_.end(),
                     [](const Hit& a, const Hit& b) { return a.depth < b.depth; });
    std::array<double, mostSamples> left{};  // of the light behind what each sample met
    left.fill(1.0);
    double all = samples_;  // the sum of them
    for (auto hit = hits_.begin(); hit != hits_.end() && all > leftBehind * samples_;) {
        Group group;
        const double first = hit->depth;
        std::uint32_t met = 0;  // a bit a sample
        for (; hit != hits_.end() && hit->depth - first <= gap_ && (met >> hit->sample & 1U) == 0; ++hit) {
            const double lost = left[hit->sample] * opacity_;
            met |= 1U << hit->sample;
            left[hit->sample] -= lost;
            group.lost += lost;
            group.light += lost * hit->color;
            group.depth += lost * hit->depth;
        }
        const auto opacity = static_cast<float>(std::min(group.lost / all, 1.0));
        if (opacity > 0.0F) {
            fragments.push_back({.column = column,
                                 .row = row,
                                 .depth = group.depth / group.lost,
                                 .opacity = opacity,
                                 .color = glm::vec3(group.light / group.lost)});
        }
        all -= group.lost;
    }
    hits_.clear();
}

}  // namespace mote::render
