// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/screen_dots.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <atomic>
#include <cstdint>
#include <new>
#include <numeric>

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

}  // namespace

void placeDots(const FramePlan& plan, PlacedDots& placed) {
    std::size_t count = plan.dots ? plan.dots->size() : 0;
    for (const auto& fragments : plan.fragments) count += fragments->size();
    resizeInTurns(placed.dots, count);
    resizeInTurns(placed.depths, count);
    std::size_t at = 0;
    const auto append = [&](const auto& list) {
        place(list, plan.sections, at, placed);
        at += list.size();
    };
    if (plan.dots) append(*plan.dots);
    for (const auto& fragments : plan.fragments) append(*fragments);
}

std::vector<std::shared_ptr<const FragmentMaker>> makersOf(const FramePlan& plan) {
    auto makers = plan.surfaces;
    for (const auto& strokes : plan.strokes)
        makers.push_back(std::make_shared<const StrokeFragments>(strokes, plan.width, plan.height,
                                                                 nearLimit(plan.camera)));
    return makers;
}

void placeMade(const std::vector<std::shared_ptr<const FragmentMaker>>& makers, const PixelRect& pixels,
               std::span<const DepthSection> sections, PlacedDots& placed) {
    Fragments fragments;
    for (const auto& maker : makers) maker->make(pixels, fragments);
    for (const auto& fragment : fragments) {
        placed.dots.push_back(toScreen(fragment));
        placed.dots.back().place = static_cast<float>(slabOf(sections, fragment.depth));
        placed.depths.push_back(fragment.depth);
    }
}

Fragments allOf(const FragmentMaker& maker, std::uint32_t width, std::uint32_t height) {
    constexpr std::size_t most = std::size_t{1} << 26;  // 2 GB
    std::vector<Fragments> rows(height);
    std::atomic<std::size_t> count{0};
    tbb::parallel_for(0U, height, [&](std::uint32_t row) {
        maker.make({0, row, width, row + 1}, rows[row]);
        if (count += rows[row].size(); count > most) throw std::bad_alloc();
    });
    Fragments all;
    all.reserve(count);
    for (auto& row : rows) {
        all.insert(all.end(), row.begin(), row.end());
        row = {};
    }
    return all;
}

std::vector<std::uint32_t> frontToBack(const PlacedDots& placed) {
    std::vector<std::uint32_t> order(placed.dots.size());
    std::iota(order.begin(), order.end(), 0U);
    tbb::parallel_sort(order, [&](std::uint32_t a, std::uint32_t b) { return placed.before(a, b); });
    return order;
}

}  // namespace mote::render
