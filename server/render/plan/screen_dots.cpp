// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/screen_dots.h"

#include <tbb/parallel_sort.h>

#include <cstdint>
#include <numeric>
#include <span>
#include <utility>

#include "server/render/plan/in_turns.h"
#include "server/render/plan/long_list.h"
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

/// Places a list from index `at` on.
template <class List>
void place(const List& list, std::span<const DepthSection> sections, std::size_t at, PlacedDots& placed) {
    constexpr std::size_t grain = std::size_t{1} << 13;
    forRangesInTurns(list.size(), grain, [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            auto& dot = placed.dots[at + i] = toScreen(list[i]);
            dot.place = static_cast<float>(slabOf(sections, list[i].depth));
            placed.depths[at + i] = list[i].depth;
        }
    });
}

std::vector<Fragments> fragmentsOf(const FramePlan& plan) {
    std::vector<Fragments> all;
    for (const auto& strokes : plan.strokes) {
        for (auto& part : strokeFragments(*strokes, plan.width, plan.height, nearLimit(plan.camera)))
            all.push_back(std::move(part));
    }
    return all;
}

}  // namespace

void placeDots(const FramePlan& plan, PlacedDots& placed) {
    auto strokes = fragmentsOf(plan);
    std::size_t count = plan.dots ? plan.dots->size() : 0;
    for (const auto& fragments : plan.fragments) count += fragments->size();
    for (const auto& fragments : strokes) count += fragments.size();
    resizeInTurns(placed.dots, count);
    resizeInTurns(placed.depths, count);
    std::size_t at = 0;
    const auto append = [&](const auto& list) {
        place(list, plan.sections, at, placed);
        at += list.size();
    };
    if (plan.dots) append(*plan.dots);
    for (const auto& fragments : plan.fragments) append(*fragments);
    for (auto& fragments : strokes) append(std::exchange(fragments, {}));
}

std::vector<ScreenDot> screenDots(const FramePlan& plan) {
    PlacedDots placed;
    placeDots(plan, placed);
    std::vector<std::uint32_t> order(placed.dots.size());
    std::iota(order.begin(), order.end(), 0U);
    tbb::parallel_sort(order, [&](std::uint32_t a, std::uint32_t b) { return placed.before(a, b); });
    std::vector<ScreenDot> sorted;
    sorted.reserve(order.size());
    for (const auto index : order) sorted.push_back(placed.dots[index]);
    return sorted;
}

}  // namespace mote::render
