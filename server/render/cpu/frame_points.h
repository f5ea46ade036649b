// SPDX-License-Identifier: GPL-3.0-or-later
//
// FramePoints: the points of all layers of one picture, ready to be gathered tile by tile. Owned by the
// device, its memory reused from picture to picture.
#pragma once

#include <oneapi/tbb/enumerable_thread_specific.h>

#include <span>
#include <stop_token>
#include <vector>

#include "server/render/cpu/leaf_cells.h"
#include "server/render/cpu/tile_cells.h"
#include "server/render/cpu/tile_points.h"

namespace mote::render {

class FramePoints {
  public:
    /// As TilePoints::sort, for each layer.
    bool sort(const FramePlan& plan, ResidentLeaves& leaves, const std::stop_token& stop);

    /// Whether any layer may have cells in a tile.
    bool any(Tile tile) const;
    /// The cells of a tile, one a layer. They belong to the calling thread, which may add to them, until it
    /// asks again.
    std::span<TileCells> gather(Tile tile);
    /// Appends the points of a tile that have no cells since they stand alone, layer by layer. From any
    /// thread.
    void appendAlone(Tile tile, std::vector<ScreenDot>& out) const;
    /// `alone`: also those that stand alone.
    std::uint64_t pointsDrawn(bool alone = true) const;

  private:
    std::vector<TilePoints> layers_;
    tbb::enumerable_thread_specific<std::vector<TileCells>> cells_;
};

}  // namespace mote::render
