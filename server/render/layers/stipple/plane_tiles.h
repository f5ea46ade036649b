// SPDX-License-Identifier: GPL-3.0-or-later
//
// PlaneTiles: a hierarchy of the periodic unit square, repeated over a picture. Selection by removal against
// the wanted density around each point's first position, and replay by prefix across the seams (dissertation
// 2.2.3.3, docs/STIPPLES.md). Made once for a hierarchy; immutable, shared by pictures; deterministic on any
// number of threads.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "server/render/layers/stipple/pixel_map.h"
#include "storage/stipple/stipple_hierarchy.h"

namespace mote::render {

/// How a picture is laid over the tiles.
struct TileFrame {
    double density = 0.0;     ///< of all points of the hierarchy, dots a square pixel
    double sampleSide = 1.0;  ///< of the square that is averaged, over the side of the point's own cell
};

/// A point of a tile that is drawn.
struct TileDot {
    std::int32_t column = 0;  ///< of its tile; 0 begins at the picture's left edge
    std::int32_t row = 0;     ///< of its tile; 0 begins at its upper edge
    std::uint32_t point = 0;  ///< index in the hierarchy
    glm::vec2 place{0.0F};    ///< pixels from the picture's upper left corner; may lie outside
};

/// The tiles that meet a picture with its margin.
struct Tiling {
    double side = 1.0;    ///< of a tile, pixels
    double margin = 0.0;  ///< around the picture, pixels
    int firstColumn = 0, firstRow = 0;
    int columns = 0, rows = 0;
    double right = 0.0, bottom = 0.0;  ///< of the margin, pixels

    bool has(int column, int row) const {
        return column >= firstColumn && row >= firstRow && column < firstColumn + columns &&
               row < firstRow + rows;
    }
    std::size_t index(int column, int row) const {
        return static_cast<std::size_t>(row - firstRow) * static_cast<std::size_t>(columns) +
               static_cast<std::size_t>(column - firstColumn);
    }
};

/// Which points of which tiles are drawn: the dots, and a flag for each point of each tile.
struct TileSelection {
    Tiling tiling;
    std::vector<std::uint8_t> drawn;  ///< by tile, then point
    std::vector<TileDot> dots;
};

class PlaneTiles {
  public:
    /// `hierarchy` is consistent and of the plane.
    explicit PlaneTiles(std::shared_ptr<const storage::StippleHierarchy> hierarchy);

    std::size_t size() const { return hierarchy_->size(); }
    /// That it takes in memory, with its hierarchy.
    std::uint64_t bytes() const;

    /// The dots that the density asks for, not yet placed; also those somewhat outside of the picture, which
    /// is taken to go on as at its edge: they keep the dots within from drifting out.
    TileSelection select(const PixelMap& wanted, const TileFrame& frame) const;
    /// Puts each dot where its undrawn neighbours let it go.
    void place(TileSelection& selection) const;
    /// The undrawn point whose first position is nearest to a place, among those around it; if there is
    /// one, it is drawn from now on and returned, not yet among the dots.
    std::optional<TileDot> wake(TileSelection& selection, const glm::dvec2& place) const;
    void letSleep(TileSelection& selection, const TileDot& dot) const {
        selection.drawn[flagOf(selection.tiling, dot)] = 0;
    }

  private:
    /// A point's first position and when it is removed, in the order of cells of a grid.
    struct Candidate {
        float x, y;  ///< in the unit square
        float left;  ///< (points - 1/2 - removal) / points: the share below which it is not drawn
        std::uint32_t point;
    };

    std::size_t flagOf(const Tiling& tiling, const TileDot& dot) const {
        return tiling.index(dot.column, dot.row) * size() + dot.point;
    }
    std::vector<TileDot> find(const PixelMap& wanted, const Tiling& tiling, const TileFrame& frame) const;
    glm::vec2 placed(const TileDot& dot, const TileSelection& selection) const;

    std::shared_ptr<const storage::StippleHierarchy> hierarchy_;
    int gridSide_;  ///< cells along a side of the tile
    std::vector<Candidate> candidates_;
    std::vector<std::uint32_t> cellBegin_;  ///< by cell of the grid, row by row
};

}  // namespace mote::render
