// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/tile_dots.h"

#include <algorithm>
#include <cmath>

namespace mote::render {
namespace {

/// The pixels of a tile, 0 to Tile::edge, that a dot may touch along one axis.
struct Reach {
    std::uint32_t begin, end;

    Reach(float centre, float reach, std::uint32_t tile) {
        const auto first = static_cast<float>(tile * Tile::edge);
        constexpr auto edge = static_cast<float>(Tile::edge);
        // Pixel i has its centre at i + 1/2.
        begin = static_cast<std::uint32_t>(std::clamp(std::floor(centre - reach - first), 0.0F, edge));
        end = static_cast<std::uint32_t>(std::clamp(std::ceil(centre + reach - first), 0.0F, edge));
    }
};

}  // namespace

void TileDots::set(Tile tile, std::span<const ScreenDot> dots, std::span<const std::uint32_t> own,
                   std::uint32_t slabs) {
    placed_.clear();
    occupied_.assign(slabs, 0);
    for (const std::uint32_t index : own) spread(tile, dots[index], slabs);
    begin_.fill(0);
    for (const auto& placed : placed_) ++begin_[placed.pixel + 1];
    for (std::uint32_t i = 0; i < Tile::pixels; ++i) begin_[i + 1] += begin_[i];
    hits_.resize(placed_.size());
    // Each pixel's hits stay in their order, which is front to back.
    auto next = begin_;
    for (const auto& placed : placed_) hits_[next[placed.pixel]++] = placed.hit;
}

void TileDots::spread(Tile tile, const ScreenDot& dot, std::uint32_t slabs) {
    const Reach columns(dot.x, dot.ink.reach, tile.column), rows(dot.y, dot.ink.reach, tile.row);
    const std::uint32_t slab = std::min(static_cast<std::uint32_t>(dot.place), slabs - 1);
    for (std::uint32_t row = rows.begin; row < rows.end; ++row) {
        const float dy = static_cast<float>(tile.row * Tile::edge + row) + 0.5F - dot.y;
        for (std::uint32_t column = columns.begin; column < columns.end; ++column) {
            const float dx = static_cast<float>(tile.column * Tile::edge + column) + 0.5F - dot.x;
            const float opacity = dot.ink.coverage(std::sqrt(dx * dx + dy * dy));
            if (!(opacity > 0.0F)) continue;
            const std::uint32_t pixel = Tile::pixelIndex(column, row);
            placed_.push_back({pixel, {dot.place, opacity, dot.color}});
            occupied_[slab] |= std::uint64_t{1} << (pixel / Tile::packetPixels);
        }
    }
}

}  // namespace mote::render
