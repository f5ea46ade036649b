// SPDX-License-Identifier: GPL-3.0-or-later
//
// TileCells: the points of one layer in one tile, gathered by pixel and by depth slab of those that the layer
// lies in, which are counted from its first. Reused from tile to tile
// by the thread that owns it; what is added in the same order gives the same sums.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "server/render/cpu/tile.h"

namespace mote::render {

/// The meeting of a pixel and a slab.
struct PointCell {
    float weight;  ///< sum over its points; a whole point at full fraction has 1: optical depth over that of
                   ///< one
    float depth;   ///< sum of weight * place within the slab, 0 (front) to 1
};

/// The levels (DensityLevels) of a pixel's points, whatever their depth.
struct PixelShade {
    float weight;  ///< of the points: what they cover of the pixel
    float level;   ///< sum of weight * level
};

class TileCells {
  public:
    /// `firstSlab`: among those of the picture. `shaded`: the levels of points are told.
    explicit TileCells(std::uint32_t slabs, std::uint32_t firstSlab = 0, bool shaded = false)
        : first_(firstSlab),
          slabs_(slabs),
          shades_(shaded ? Tile::pixels : 0),
          cells_(std::size_t{slabs} * Tile::packets),
          touched_(std::size_t{slabs} * Tile::packets),
          occupied_(slabs) {}

    std::uint32_t slabs() const { return slabs_; }
    std::uint32_t firstSlab() const { return first_; }
    /// The cells of a slab, by Tile::pixelIndex.
    const PointCell* slab(std::uint32_t slab) const {
        return cells_[std::size_t{slab} * Tile::packets].data();
    }
    /// One bit a packet of 4 x 4 pixels, from bit 0: whether its cells in this slab may hold points. As of
    /// the latest settle().
    std::uint64_t occupied(std::uint32_t slab) const { return occupied_[slab]; }
    bool empty() const {
        return std::all_of(occupied_.begin(), occupied_.end(), [](std::uint64_t bits) { return bits == 0; });
    }

    bool shaded() const { return !shades_.empty(); }
    /// By Tile::pixelIndex, if they are shaded.
    const PixelShade* shades() const { return shades_.data(); }
    PixelShade* shades() { return shades_.data(); }

    /// [slab][pixelIndex]
    PointCell* cells() { return cells_.empty() ? nullptr : cells_.front().data(); }
    /// [slab][packet]: to be set to 1 by who adds to one of its cells. Bytes, as a bit would have to be read.
    std::uint8_t* touched() { return touched_.data(); }
    /// To be called when all is added.
    void settle() {
        for (std::uint32_t s = 0; s < slabs_; ++s)
            occupied_[s] = bitsOf(touched_.data() + std::size_t{s} * Tile::packets);
    }

    /// Empties what is occupied.
    void clear() {
        for (std::uint32_t s = 0; s < slabs_; ++s) {
            if (occupied_[s] == 0) continue;
            for (std::uint64_t left = occupied_[s]; left != 0; left &= left - 1) {
                const auto packet = static_cast<std::size_t>(std::countr_zero(left));
                cells_[std::size_t{s} * Tile::packets + packet].fill({0.0F, 0.0F});
            }
            std::fill_n(touched_.data() + std::size_t{s} * Tile::packets, Tile::packets, std::uint8_t{0});
            occupied_[s] = 0;
        }
        std::fill(shades_.begin(), shades_.end(), PixelShade{0.0F, 0.0F});
    }

  private:
    /// In whole cache lines, so that no vector of them lies in two more than it must.
    struct alignas(64) PacketCells : std::array<PointCell, Tile::packetPixels> {};
    static_assert(sizeof(PacketCells) == Tile::packetPixels * sizeof(PointCell));
    static_assert(Tile::packets == 64, "one bit a packet");
    static_assert(std::endian::native == std::endian::little);

    /// A bit for each of 64 bytes that are 0 or 1: eight at a time, the product brings them side by side.
    static std::uint64_t bitsOf(const std::uint8_t* bytes) {
        std::uint64_t bits = 0;
        for (std::uint32_t i = 0; i < Tile::packets; i += 8) {
            std::uint64_t eight = 0;
            std::memcpy(&eight, bytes + i, sizeof(eight));
            bits |= (eight * 0x0102040810204080U >> 56) << i;
        }
        return bits;
    }

    std::uint32_t first_, slabs_;
    std::vector<PixelShade> shades_;
    std::vector<PacketCells> cells_;  // [slab][packet]
    std::vector<std::uint8_t> touched_;
    std::vector<std::uint64_t> occupied_;
};

}  // namespace mote::render
