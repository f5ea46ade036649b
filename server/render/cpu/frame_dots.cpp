// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/frame_dots.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace mote::render {
namespace {

constexpr std::size_t chunkDots = 4096;

/// By depth, of equal depth in their order: the bits of floats that are not negative ascend with them.
std::uint64_t sortKey(float place, std::uint32_t index) {
    return std::uint64_t{std::bit_cast<std::uint32_t>(std::max(place, 0.0F))} << 32 | index;
}

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
    columns_ = tilesAcross(plan.width);
    const std::uint32_t rows = tilesAcross(plan.height);
    const auto dots = screenDots(plan);
    dots_.assign(dots.begin(), dots.end());
    addScreenSplats(plan, looks_, dots_);
    splats_ = dots_.size() - dots.size();
    tiles_.clear(std::size_t{columns_} * rows);
    const std::size_t chunks = (dots_.size() + chunkDots - 1) / chunkDots;
    tiles_.fill(
        std::size_t{columns_} * rows, chunks, stop, [](std::size_t) {},
        [&](std::size_t chunk, auto visit) {
            const std::size_t end = std::min(dots_.size(), (chunk + 1) * chunkDots);
            for (std::size_t i = chunk * chunkDots; i < end; ++i) {
                const auto item = static_cast<std::uint32_t>(i);
                forTiles(dots_[i], columns_, rows, [&](std::size_t tile) { visit(tile, item); });
            }
        });
}

const TileDots* FrameDots::of(Tile tile) {
    if (dots_.empty()) return nullptr;
    const auto own = tiles_.of(std::size_t{tile.row} * columns_ + tile.column);
    if (own.empty()) return nullptr;
    Local& local = local_.local();
    local.keys.clear();
    for (const std::uint32_t index : own) local.keys.push_back(sortKey(dots_[index].place, index));
    std::sort(local.keys.begin(), local.keys.end());
    local.own.clear();
    for (const std::uint64_t key : local.keys) local.own.push_back(static_cast<std::uint32_t>(key));
    local.dots.set(tile, dots_, local.own, slabs_);
    return &local.dots;
}

}  // namespace mote::render
