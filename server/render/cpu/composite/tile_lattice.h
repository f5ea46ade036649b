// SPDX-License-Identifier: GPL-3.0-or-later
//
// TileLattice: what the fields of a tile give off and let through, told by rays sixteen, eight, four or two
// pixels apart, where all pixels between follow from those (docs/RENDERING.md, "Lattices"). Rays are walked
// in rounds, each among what the one before was too coarse for: whoever owns it asks which nodes are wanted,
// tells them, and lets it judge. What it decides depends on nothing but what it was told, so the picture is
// the same on any number of threads. Owned by one thread.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "server/render/cpu/composite/composite_frame.h"
#include "server/render/cpu/composite/packet.h"
#include "server/render/cpu/tile.h"
#include "server/render/cpu/tile_cells.h"

namespace mote::render {

class TileLattice {
  public:
    static constexpr std::uint32_t apart = 2;  ///< nodes, pixels
    static constexpr std::uint32_t across = Tile::edge / apart + 1, nodes = across * across;
    /// Of a ray from its front to a border of slabs: what is left of light from behind (NaN: it is not
    /// known), and the light gathered, linear red, green and blue.
    using Told = std::array<float, 4>;

    /// For points of these cells, or none.
    TileLattice(const CompositeFrame& frame, Tile tile, std::span<const TileCells> points);

    /// The borders of slabs that are to be told, ascending: those around slabs with points where fields may
    /// be, one before and one behind them, and the last; and one that lies beyond all.
    const float* borders() const { return borders_.data(); }
    /// The slab behind which no pixel shows anything.
    std::uint32_t end() const { return end_; }
    /// The nodes that are to be walked now.
    std::span<const std::uint32_t> wanted() const { return wanted_; }
    /// Where up to as many nodes as a packet has pixels are; the last is repeated.
    PacketPlaces places(std::span<const std::uint32_t> some) const;
    /// `row`: of borders, or that beyond all. Those of a node lie one after another.
    Told& at(std::size_t row, std::uint32_t node) { return told_[node * borders_.size() + row]; }
    const Told& at(std::size_t row, std::uint32_t node) const { return told_[node * borders_.size() + row]; }

    /// To be called when all wanted nodes are told: others may be wanted then.
    void judge();

    /// Whether the pixels of a packet follow from the nodes around it.
    bool smooth(std::uint32_t packet) const { return steps_[packet] != 0; }
    /// The nodes that a smooth packet follows from: three in each of three rows.
    struct Around {
        std::uint32_t first, step;
        glm::vec2 corner;  ///< of the packet: from the first node, over the distance between two
        float pixel;       ///< a pixel's edge, likewise
    };
    Around around(std::uint32_t packet) const;
    /// Whether nothing is seen between those of a smooth packet.
    bool blank(std::uint32_t packet) const;
    /// Of the border before a slab with points; that behind it has the next one.
    std::size_t row(std::uint32_t slab) const { return rows_[slab]; }
    std::size_t lastRow() const { return rowCount_ - 1; }

  private:
    struct Following;
    struct Square {
        std::uint32_t x, y;  // its first node
    };

    /// A slab with points, or several that are like one.
    struct OccupiedSlab {
        std::uint32_t row;      // of the border before it
        std::uint64_t packets;  // that may have points there, a bit each
    };

    std::uint32_t addBorder(std::uint32_t slab);
    void wantNodes();
    std::vector<std::uint32_t> rowsOf(const Square& part) const;
    bool thin(const Square& part, std::span<const std::uint32_t> rows) const;
    bool thinAt(std::uint32_t node, std::span<const std::uint32_t> rows) const;
    void agree(const Square& part);
    bool agrees(const Square& square, std::uint32_t quadrant, std::span<const std::uint32_t> rows) const;
    template <std::size_t count>
    bool agreesBy(std::uint32_t node, const Following& following, std::span<const std::uint32_t> rows) const;

    const Tile tile_;
    const std::uint32_t end_;
    std::vector<float> borders_;  // slabs, and one beyond all
    std::size_t rowCount_;        // of them, without that
    std::vector<std::uint32_t> wanted_;
    std::vector<std::uint32_t> rows_;     // by slab
    std::vector<OccupiedSlab> occupied_;  // ascending
    std::unique_ptr<Told[]> told_;        // [node][border]
    std::array<bool, nodes> known_{};     // or wanted
    // Of this round: nodes so far apart, in these squares of 5 x 5 of them.
    std::uint32_t step_;
    std::vector<Square> squares_;
    std::array<std::uint8_t, Tile::packets> steps_{};  // of smooth packets, else 0
};

}  // namespace mote::render
