// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/tile_dots.h"

#include <algorithm>
#include <cmath>

#include "server/render/cpu/point_footprint.h"

namespace mote::render {
namespace {

// What is behind less is not seen, as of all that rays meet.
constexpr float opaque = 5e-5F;

/// The pixels of a tile, 0 to Tile::edge, that a dot may touch along one axis.
struct Reach {
    std::uint32_t begin, end;

    std::uint32_t count() const { return std::max(end, begin) - begin; }
    Reach(float centre, float reach, std::uint32_t tile) {
        const auto first = static_cast<float>(tile * Tile::edge);
        constexpr auto edge = static_cast<float>(Tile::edge);
        // Pixel i has its centre at i + 1/2, and what has no reach is in the pixel that holds it. A fragment,
        // which reaches to the next centres, touches its own pixel alone.
        const float at = reach > 0.0F ? centre - 0.5F - first : std::floor(centre - first);
        const float from = reach > 0.0F ? std::floor(at - reach) + 1.0F : at;
        const float last = reach > 0.0F ? std::ceil(at + reach) : at + 1.0F;
        begin = static_cast<std::uint32_t>(std::clamp(from, 0.0F, edge));
        end = static_cast<std::uint32_t>(std::clamp(last, 0.0F, edge));
    }
};

}  // namespace

void TileDots::set(Tile tile, std::span<const TileDot> dots, std::uint32_t slabs) {
    placedCount_ = 0;
    occupied_.assign(slabs, 0);
    left_.fill(1.0F);
    for (const auto& one : dots) spread(tile, one, slabs);
    const std::span placed(placed_.data(), placedCount_);
    begin_.fill(0);
    for (const auto& one : placed) ++begin_[one.pixel + 1];
    for (std::uint32_t i = 0; i < Tile::pixels; ++i) begin_[i + 1] += begin_[i];
    hits_.resize(placed.size());
    // Each pixel's hits stay in their order, which is front to back.
    auto next = begin_;
    for (const auto& one : placed) hits_[next[one.pixel]++] = one.hit;
}

void TileDots::spread(Tile tile, const TileDot& one, std::uint32_t slabs) {
    const ScreenDot& dot = *one.dot;
    const Reach columns(dot.x, dot.ink.reach, tile.column), rows(dot.y, dot.ink.reach, tile.row);
    const std::size_t most = placedCount_ + std::size_t{columns.count()} * rows.count();
    if (placed_.size() < most) placed_.resize(2 * most);
    const bool small = !(dot.ink.reach > 0.0F);
    std::uint64_t packets = 0;
    for (std::uint32_t row = rows.begin; row < rows.end; ++row) {
        const float dy = static_cast<float>(tile.row * Tile::edge + row) + 0.5F - dot.y;
        for (std::uint32_t column = columns.begin; column < columns.end; ++column) {
            const std::uint32_t pixel = Tile::pixelIndex(column, row);
            if (left_[pixel] < opaque) continue;
            const float dx = static_cast<float>(tile.column * Tile::edge + column) + 0.5F - dot.x;
            const float whole = small ? dot.ink.most : dot.ink.coverage(std::sqrt(dx * dx + dy * dy));
            const float opacity =
                one.tau >= 0.0F ? -std::expm1(-one.tau * whole) : thinnedOpacity(whole, one.thinned);
            if (!(opacity > 0.0F)) continue;
            left_[pixel] *= 1.0F - opacity;
            const std::uint32_t x = tile.column * Tile::edge + column, y = tile.row * Tile::edge + row;
            const bool own = one.colors != nullptr && x < one.colors->width() && y < one.colors->height();
            placed_[placedCount_++] = {pixel, {dot.place, opacity, own ? one.colors->at(x, y) : dot.color}};
            packets |= std::uint64_t{1} << (pixel / Tile::packetPixels);
        }
    }
    occupied_[std::min(static_cast<std::uint32_t>(dot.place), slabs - 1)] |= packets;
}

}  // namespace mote::render
