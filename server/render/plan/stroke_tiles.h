// SPDX-License-Identifier: GPL-3.0-or-later
//
// StrokeTiles: which parts of strokes may touch which tiles of a picture. Made for one picture's fragments;
// immutable, safe on any number of threads.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "server/render/plan/stroke.h"
#include "server/render/plan/tile_lists.h"

namespace mote::render {

/// Pixels of a side from `begin` to before `end`.
struct PixelSpan {
    std::uint32_t begin = 0, end = 0;

    bool empty() const { return begin >= end; }
};

/// The pixels, of `side` in all, whose middles lie between two places. Inline and without ceil and floor: it
/// is asked for every row of every segment.
inline PixelSpan pixelsBetween(double low, double high, std::uint32_t side) {
    const double first = std::min<double>(side, std::max(0.0, low - 0.5));
    const auto begin = static_cast<std::uint32_t>(first);
    const auto end = static_cast<std::uint32_t>(std::min<double>(side, std::max(0.0, high + 0.5)));
    return {begin < first ? begin + 1 : begin, end};
}

class StrokeTiles {
  public:
    static constexpr std::uint32_t edge = 32;  ///< of a tile, pixels

    /// A line's part from a point to the next, or its only point.
    struct LinePart {
        std::uint32_t line = 0, point = 0;
    };
    /// An outline's edge from a point to another.
    struct AreaEdge {
        std::uint32_t area = 0, from = 0, to = 0;
    };

    /// In turns (in_turns.h), on all threads of the calling arena. Throws std::bad_alloc.
    StrokeTiles(const Strokes& strokes, std::uint32_t width, std::uint32_t height);

    std::uint32_t columns() const { return columns_; }
    std::uint32_t rows() const { return rows_; }
    /// In order: parts of lines by the numbers of lines and points.
    std::span<const LinePart> lines(std::uint32_t column, std::uint32_t row) const {
        return lines_.of(std::size_t{row} * columns_ + column);
    }
    /// Edges by the numbers of their areas.
    std::span<const AreaEdge> edges(std::uint32_t row) const { return edges_.of(row); }
    /// Pixels from a line's nearest place from which on it covers nothing.
    double reach(std::uint32_t line) const { return reach_[line]; }
    /// Columns that an area may touch.
    const PixelSpan& across(std::uint32_t area) const { return across_[area]; }

    std::uint64_t bytes() const {
        return lines_.bytes() + edges_.bytes() + reach_.capacity() * sizeof(double) +
               across_.capacity() * sizeof(PixelSpan);
    }

  private:
    std::uint32_t columns_, rows_;
    std::vector<double> reach_;      // of lines
    std::vector<PixelSpan> across_;  // of areas
    TileLists<LinePart> lines_;
    TileLists<AreaEdge> edges_;  // by rows of tiles
};

}  // namespace mote::render
