// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/screen_dots.h"

#include <tbb/parallel_sort.h>

#include <cstdint>
#include <utility>

#include "server/render/plan/stroke_fragments.h"

namespace mote::render {
namespace {

ScreenDot toScreen(const Dot& dot) {
    ScreenDot shown{.x = dot.x, .y = dot.y, .ink = DotFootprint(dot.radius), .color = dot.color};
    shown.ink.most *= dot.opacity;
    return shown;
}

/// It covers its own pixel and ends where the next ones have their centres.
ScreenDot toScreen(const Fragment& fragment) {
    return {.x = static_cast<float>(fragment.column) + 0.5F,
            .y = static_cast<float>(fragment.row) + 0.5F,
            .ink = DotFootprint(1.0F, fragment.opacity),
            .color = fragment.color};
}

}  // namespace

std::vector<ScreenDot> screenDots(const FramePlan& plan) {
    std::vector<ScreenDot> dots;
    std::vector<std::pair<double, std::uint32_t>> order;  // depth; which one
    const auto append = [&](const auto& list) {
        for (const auto& one : list) {
            order.emplace_back(one.depth, static_cast<std::uint32_t>(dots.size()));
            dots.push_back(toScreen(one));
        }
    };
    if (plan.dots) append(*plan.dots);
    for (const auto& fragments : plan.fragments) append(*fragments);
    for (const auto& strokes : plan.strokes) {
        for (const auto& part : strokeFragments(*strokes, plan.width, plan.height, nearLimit(plan.camera)))
            append(part);
    }
    tbb::parallel_sort(order);
    std::vector<ScreenDot> sorted;
    sorted.reserve(dots.size());
    for (const auto& [depth, index] : order) {
        sorted.push_back(dots[index]);
        sorted.back().place = static_cast<float>(slabOf(plan.sections, depth));
    }
    return sorted;
}

}  // namespace mote::render
