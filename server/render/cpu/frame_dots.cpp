// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/frame_dots.h"

#include <algorithm>
#include <cmath>

#include "server/render/plan/in_turns.h"

namespace mote::render {
namespace {

constexpr std::size_t chunkDots = 4096;

/// Calls visit(tile) for each tile that a dot may touch.
template <class Visit>
void forTiles(const ScreenDot& dot, std::uint32_t columns, std::uint32_t rows, Visit visit) {
    const auto first = [](float at) {
        return static_cast<std::uint32_t>(std::max(std::floor(at / Tile::edge), 0.0F));
    };
    const auto end = [](float at, std::uint32_t most) {
        return static_cast<std::uint32_t>(
            std::clamp(std::floor(at / Tile::edge) + 1.0F, 0.0F, static_cast<float>(most)));
    };
    const std::uint32_t bottom = end(dot.y + dot.ink.reach, rows);
    const std::uint32_t right = end(dot.x + dot.ink.reach, columns);
    for (std::uint32_t row = first(dot.y - dot.ink.reach); row < bottom; ++row) {
        for (std::uint32_t column = first(dot.x - dot.ink.reach); column < right; ++column)
            visit(row * columns + column);
    }
}

}  // namespace

void FrameDots::sort(const FramePlan& plan, const std::stop_token& stop) {
    slabs_ = plan.slabs;
    width_ = plan.width;
    height_ = plan.height;
    columns_ = tilesAcross(plan.width);
    sections_ = plan.sections;
    makers_ = makersOf(plan);
    const std::uint32_t rows = tilesAcross(plan.height);
    const std::size_t tiles = std::size_t{columns_} * rows;
    placeDots(plan, placed_);
    const auto& dots = placed_.dots;
    const std::size_t chunks = (dots.size() + chunkDots - 1) / chunkDots;
    if (chunks == 0) return tiles_.clear(tiles);
    tiles_.fill(
        tiles, chunks, stop, [](std::size_t) {},
        [&](std::size_t chunk, auto visit) {
            const std::size_t end = std::min(dots.size(), (chunk + 1) * chunkDots);
            for (std::size_t i = chunk * chunkDots; i < end; ++i) {
                const auto item = static_cast<std::uint32_t>(i);
                forTiles(dots[i], columns_, rows, [&](std::size_t tile) { visit(tile, item); });
            }
        });
    if (stop.stop_requested()) return;
    forInTurns(std::size_t{0}, tiles, [&](std::size_t tile) {
        const auto list = tiles_.of(tile);
        std::sort(list.begin(), list.end(),
                  [&](std::uint32_t a, std::uint32_t b) { return placed_.before(a, b); });
    });
}

/// What is made of it, among its dots.
void FrameDots::make(Tile tile, Local& local) const {
    const std::uint32_t left = tile.column * Tile::edge, top = tile.row * Tile::edge;
    local.made.dots.clear();
    local.made.depths.clear();
    placeMade(makers_, {left, top, std::min(left + Tile::edge, width_), std::min(top + Tile::edge, height_)},
              sections_, local.made);
    local.placed.clear();
    if (!placed_.dots.empty()) {
        for (const auto dot : tiles_.of(std::size_t{tile.row} * columns_ + tile.column))
            local.placed.emplace_back(placed_.depths[dot], &placed_.dots[dot]);
    }
    for (std::size_t i = 0; i < local.made.dots.size(); ++i)
        local.placed.emplace_back(local.made.depths[i], &local.made.dots[i]);
    // What an image gives is in order already.
    const auto nearer = [](const auto& a, const auto& b) { return a.first < b.first; };
    if (!std::is_sorted(local.placed.begin(), local.placed.end(), nearer))
        std::stable_sort(local.placed.begin(), local.placed.end(), nearer);
    for (const auto& [depth, dot] : local.placed) local.all.push_back({dot});
}

const TileDots* FrameDots::of(Tile tile, const FramePoints& points) {
    Local& local = local_.local();
    local.points.clear();
    local.all.clear();
    points.appendAlone(tile, local.points);
    for (const auto& point : local.points)
        local.all.push_back({&point.dot, point.thinned, point.tau, point.colors});
    if (!makers_.empty()) {
        make(tile, local);
    } else if (!placed_.dots.empty()) {
        for (const auto dot : tiles_.of(std::size_t{tile.row} * columns_ + tile.column))
            local.all.push_back({&placed_.dots[dot]});
    }
    if (local.all.empty()) return nullptr;
    // Dots are front to back already; one at a point's depth lies behind it.
    if (!local.points.empty())
        std::stable_sort(local.all.begin(), local.all.end(),
                         [](const TileDot& a, const TileDot& b) { return a.dot->place < b.dot->place; });
    local.tile.set(tile, local.all, slabs_);
    return &local.tile;
}

}  // namespace mote::render
