// SPDX-License-Identifier: GPL-3.0-or-later
//
// Packet: 4 x 4 pixels of a tile with their rays, points and dots. A value of one thread; it points to the
// tile's cells and dots.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "server/render/cpu/composite/composite_frame.h"
#include "server/render/cpu/tile.h"
#include "server/render/cpu/tile_cells.h"
#include "server/render/cpu/tile_dots.h"

namespace mote::render {

/// A number for each pixel of a packet.
struct alignas(64) Lanes {
    std::array<float, Tile::packetPixels> values;

    float* data() { return values.data(); }
    const float* data() const { return values.data(); }
    float& operator[](std::size_t i) { return values[i]; }
    float operator[](std::size_t i) const { return values[i]; }
};

/// Where the rays of a packet go through the picture, in pixels from its upper left corner.
using PacketPlaces = std::array<glm::dvec2, Tile::packetPixels>;

/// Between which mean slabs (FrameSection) the rays of a packet are in the box.
struct RayWays {
    std::array<double, Tile::packetPixels> enter, leave;
    double crowded = 0.0;  ///< the most segments to a mean slab
};

/// The rays of a packet through one layer's volume. A ray's way through the box is told by v from 0, where it
/// enters, to 1, where it leaves: v = clamp((slab - enter) * rate, 0, 1), and the place in cells is entry + v
/// * travel. So no rounding leads out of the padded volume. A ray that misses the box is past it everywhere.
struct PacketRays {
    std::array<Lanes, 3> entry;    ///< place in cells, of the BoxSpace
    std::array<Lanes, 3> travel;   ///< cells
    std::array<Lanes, 3> inverse;  ///< 1 / travel, finite
    Lanes length;                  ///< of the way, layer space

    // In the section that was entered.
    Lanes enter;            ///< slab; may lie outside the section
    Lanes rate;             ///< 1 / slabs
    Lanes start;            ///< v = clamp(slab * rate + start, 0, 1)
    bool meets = false;     ///< whether any ray meets the box, in any section
    bool hit = false;       ///< whether any ray meets the box there
    float nearest = 0.0F;   ///< slab in which the first ray enters
    float farthest = 0.0F;  ///< slab in which the last ray leaves
    float segment = 0.0F;   ///< slabs between two samples that bound a segment

    /// No section is entered yet.
    void aim(const CompositeFrame& frame, const RayMap& rays, const PacketPlaces& places,
             const BoxSpace& space);
    /// Where any ray meets the box.
    void enterSection(const FrameSection& section);

  private:
    RayWays ways_;
};

/// A bit a slab.
using SlabBits = std::array<std::uint64_t, mostSlabs / 64>;
/// By packet of a tile: the slabs in which any layer has points, or there are dots.
std::array<SlabBits, Tile::packets> occupiedSlabs(std::span<const TileCells> points, const TileDots* dots,
                                                  std::uint32_t slabs);

struct Packet {
    static constexpr std::size_t mostFields = View::maxLayers;

    std::array<PacketRays, mostFields> rays;  ///< of the frame's fields
    /// Red, green and blue of each layer's points.
    std::array<std::array<Lanes, 3>, View::maxLayers> pointColors;
    bool anyHit = false;     ///< whether any ray meets a field
    bool anyPoints = false;  ///< or dots
    float segment = 0.0F;    ///< slabs of the section between samples of the volumes, where one is hit

    std::span<const TileCells> points;  ///< one of the frame's each, or empty
    const TileDots* dots = nullptr;     ///< null: none in the tile
    std::uint32_t number = 0;           ///< in its tile

    /// The points and dots of packet `packet` of a tile, and the slabs that hold any in it. `x`, `y`: its
    /// first pixel in the picture.
    void setPoints(const CompositeFrame& frame, std::span<const TileCells> cells, const TileDots* tileDots,
                   std::uint32_t packet, const SlabBits& occupied, std::uint32_t x, std::uint32_t y);
    /// Its rays through the fields.
    void setRays(const CompositeFrame& frame, const PacketPlaces& places);
    /// Where no field is seen.
    void setNoRays() {
        anyHit = false;
        hitCount_ = 0;
    }

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
    void setColors(const CompositeFrame& frame, std::uint32_t x, std::uint32_t y);

    std::uint32_t slabs_ = 0;
    std::array<std::size_t, mostFields> hits_{}, inSection_{};
    std::size_t hitCount_ = 0, sectionHits_ = 0;
    SlabBits occupied_{};  // slabs with points of any layer or dots
};

/// PacketSights: what the rays of a packet see ahead in each field, kept so that all vectors of the packet's
/// rays go by the same: the picture must not depend on how many rays a vector holds. Reused from packet to
/// packet by the thread that owns it.
struct FieldSight {
    bool visible = false;  ///< by some ray, or by none
    bool fine = false;     ///< by some ray, in fine steps
    float until = -1.0F;   ///< slab up to which this holds
};

class PacketSights {
  public:
    void clear() {
        for (auto& sights : fields_) sights.clear();
    }
    /// The sight of that number in a field: walks of one packet ask for the same ones in the same order, the
    /// first that comes so far has it made by `look`.
    template <class Look>
    const FieldSight& of(std::size_t field, std::size_t number, const Look& look) {
        auto& sights = fields_[field];
        if (number == sights.size()) sights.push_back(look());
        return sights[number];
    }

  private:
    std::array<std::vector<FieldSight>, Packet::mostFields> fields_;
};

}  // namespace mote::render
