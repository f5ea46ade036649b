// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/screen_dots.h"

#include <algorithm>
#include <cstdint>
#include <numeric>

namespace mote::render {
namespace {

float placeOf(const FramePlan& plan, const Dot& dot) {
    return static_cast<float>(slabOf(plan.sections, dot.depth));
}

}  // namespace

std::vector<ScreenDot> screenDots(const FramePlan& plan) {
    if (!plan.anyDots()) return {};
    const Dots& dots = *plan.dots;
    std::vector<std::uint32_t> order(dots.size());
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return dots[a].depth < dots[b].depth; });
    std::vector<ScreenDot> result;
    result.reserve(dots.size());
    for (const std::uint32_t index : order) {
        const Dot& dot = dots[index];
        result.push_back({dot.x, dot.y, DotFootprint(dot.radius), placeOf(plan, dot), dot.color});
        result.back().ink.most *= dot.opacity;
    }
    return result;
}

}  // namespace mote::render
