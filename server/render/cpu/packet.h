// SPDX-License-Identifier: GPL-3.0-or-later
//
// Packet: 4 x 4 pixels of a tile with their rays, points and dots. A value of one thread; it points to the
// tile's cells and dots.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "server/render/cpu/composite_frame.h"
#include "server/render/cpu/packet_rays.h"
#include "server/render/cpu/tile_cells.h"
#include "server/render/cpu/tile_dots.h"

namespace mote::render {

struct Packet {
    static constexpr std::size_t mostFields = View::maxLayers;

    std::array<PacketRays, mostFields> rays;  ///< of the frame's fields
    bool anyHit = false;                      ///< whether any ray meets a field
    bool anyPoints = false;                   ///< or dots
    float segment = 0.0F;  ///< slabs of the section between samples of the volumes, where one is hit

    std::span<const TileCells> points;  ///< one of the frame's each, or empty
    const TileDots* dots = nullptr;     ///< null: none in the tile
    std::uint32_t number = 0;           ///< in its tile

    /// The packet `packet` of a tile. `x`, `y`: its first pixel in the picture.
    void set(const CompositeFrame& frame, std::span<const TileCells> cells, const TileDots* tileDots,
             std::uint32_t packet, std::uint32_t x, std::uint32_t y);

    /// Tells the rays' ways in slabs of a section.
    void enter(const FrameSection& section);
    /// The fields that some ray meets in the section.
    std::span<const std::size_t> hitFields() const { return {inSection_.data(), sectionHits_}; }
    /// The first slab from `slab` on that may hold points or dots; the number of slabs where there is none.
    std::uint32_t nextPoints(std::uint32_t slab) const;
    bool hasPoints(std::size_t layer, std::uint32_t slab) const {
        const std::uint32_t own = slab - points[layer].firstSlab();  // wraps where the layer begins later
        return own < points[layer].slabs() && (points[layer].occupied(own) >> number & 1U) != 0;
    }
    bool hasDots(std::uint32_t slab) const {
        return dots != nullptr && (dots->occupied(slab) >> number & 1U) != 0;
    }
    const PointCell* cells(std::size_t layer, std::uint32_t slab) const {
        return points[layer].slab(slab - points[layer].firstSlab()) +
               std::size_t{number} * Tile::packetPixels;
    }

  private:
    std::uint32_t slabs_ = 0;
    std::array<std::size_t, mostFields> hits_{}, inSection_{};
    std::size_t hitCount_ = 0, sectionHits_ = 0;
    std::array<std::uint64_t, mostSlabs / 64> occupied_{};  // slabs with points of any layer or dots
};

}  // namespace mote::render
