// SPDX-License-Identifier: GPL-3.0-or-later
//
// TilePoints: the points of a layer sorted by the tiles that they can touch, so that each tile is drawn by
// one thread, in the order of the file: the sums in its cells are the same for any number of threads. Owned
// by the device, its memory reused from picture to picture.
#pragma once

#include <oneapi/tbb/enumerable_thread_specific.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "server/render/cpu/leaf_cells.h"
#include "server/render/cpu/point_footprint.h"
#include "server/render/cpu/point_groups.h"
#include "server/render/cpu/point_map.h"
#include "server/render/cpu/point_stream.h"
#include "server/render/cpu/points_kernel.h"
#include "server/render/cpu/tile_cells.h"
#include "server/render/plan/pixel_colors.h"
#include "server/render/plan/screen_dots.h"
#include "server/render/plan/tile_lists.h"

namespace mote::render {

/// A point that stands alone.
struct LonePoint {
    ScreenDot dot;
    double thinned;             ///< as PointLook's
    float tau;                  ///< of a lit point (PointLook::light): its optical depth; below 0: it is not
    const PixelColors* colors;  ///< in place of the dot's, by pixel; null: none
};

/// A leaf of which points are drawn, and the tiles that they can touch.
struct DrawnLeaf {
    std::uint32_t leaf;
    TileBox box;
};

/// Points that follow each other in the file.
struct PointRun {
    std::uint64_t begin = 0, count = 0;
};

class TilePoints {
  public:
    /// Sorts what the plan selects, on all threads of the calling arena, in turns (plan/in_turns.h). False
    /// where `stop` was requested meanwhile. Throws storage::StorageError. The step must outlive what
    /// follows. `groups`: if some serve the layer (PointGroups::serve), they are drawn in place of its
    /// leaves.
    bool sort(const FramePlan& plan, const PointsPlan& layer, std::span<const LeafCell> cells,
              std::shared_ptr<const PointGroups> groups, const PixelColors* colors,
              const std::stop_token& stop);

    /// Whether each point is drawn where it stands (standAlone) and none has a cell.
    bool alone() const { return alone_; }
    /// Whether cells tell the levels of points.
    bool shaded() const { return shaded_; }
    /// Whether a tile may have cells.
    bool any(Tile tile) const {
        const std::size_t i = index(tile);
        return !alone_ &&
               (!leaves_.of(i).empty() || !discPoints_.of(i).empty() || !pixelPoints_.of(i).empty());
    }
    /// Adds the points of a tile to its cells. From any thread.
    void gather(Tile tile, TileCells& cells) const;
    /// Appends those of a tile that stand alone, in the order of the file. From any thread.
    void appendAlone(Tile tile, std::vector<LonePoint>& out) const;
    /// The picture's slabs that the points have cells in: the first, and how many, 0 where there are none.
    std::uint32_t firstSlab() const { return map_->bends.first.firstSlab; }
    std::uint32_t slabs() const { return slabs_; }
    std::uint64_t pointsDrawn() const { return pointsDrawn_; }
    /// Checks again that the bytes of the points are right, where they may have left memory since they were
    /// sorted. `layer`: as in sort(). Throws storage::StorageError.
    void verify(const PointsPlan& layer) const;
    /// In memory, about.
    std::uint64_t bytes() const;

  private:
    std::size_t index(Tile tile) const { return std::size_t{tile.row} * columns_ + tile.column; }
    float reach() const { return discs_ ? discs_->reach() : 0.0F; }
    void sortLeaves(const PointsPlan& layer, std::span<const LeafCell> cells, const std::stop_token& stop);
    void sortGroups(const std::stop_token& stop);
    template <class Chunks>
    void fillFrom(Chunks chunks, const std::stop_token& stop);
    void sortDiscs(const PreviewBlocks& blocks, const std::stop_token& stop);
    void sortPixels(const PreviewBlocks& blocks, const std::stop_token& stop);
    template <class Visit>
    void visitTiles(const ScreenPoint& point, Visit visit) const;

    bool alone_ = false, shaded_ = false;
    DotFootprint ink_{0.0F};  // of one that stands alone
    PointLook look_;
    bool perspective_ = false;
    std::vector<DepthSection> sections_;
    double thinned_ = 1.0;
    glm::vec3 color_{0.0F};
    const PixelColors* colors_ = nullptr;
    std::optional<PointMap> map_;
    std::optional<DiscFootprint> discs_;
    std::uint32_t columns_ = 0;  // of tiles
    std::size_t tiles_ = 0;
    std::shared_ptr<const PointGroups> groups_;  // in place of leaves; null: none
    TileLists<LeafPoints> leaves_;               // or groups
    TileLists<ScreenPoint> discPoints_;
    TileLists<TilePoint> pixelPoints_;
    std::vector<PointRun> verified_;  // of the leaves that are drawn
    // While they are sorted.
    std::vector<std::vector<DrawnLeaf>> drawnLeaves_;  // by chunk of leaves
    std::vector<std::uint32_t> pointTiles_;
    std::vector<TilePoint> unsorted_;
    PointStream stream_;
    const storage::PackedPosition* points_ = nullptr;
    const storage::PackedPosition* end_ = nullptr;
    std::uint32_t slabs_ = 0;
    std::uint64_t pointsDrawn_ = 0;
};

/// FramePoints: the points of all layers of one picture, ready to be gathered tile by tile. Owned by the
/// device, its memory reused from picture to picture.
class FramePoints {
  public:
    /// As TilePoints::sort, for each layer. `colors` outlive what follows. `groups`: null where not all of
    /// the points are drawn here.
    bool sort(const FramePlan& plan, ResidentLeaves& leaves, ResidentGroups* groups,
              const FrameColors& colors, const std::stop_token& stop);

    /// Whether any layer may have cells in a tile.
    bool any(Tile tile) const;
    /// The cells of a tile, one a layer. They belong to the calling thread, which may add to them, until it
    /// asks again.
    std::span<TileCells> gather(Tile tile);
    /// Appends the points of a tile that have no cells since they stand alone, layer by layer. From any
    /// thread.
    void appendAlone(Tile tile, std::vector<LonePoint>& out) const;
    /// `alone`: also those that stand alone.
    std::uint64_t pointsDrawn(bool alone = true) const;
    /// As those of TilePoints, of all layers.
    void verify(const FramePlan& plan) const;
    std::uint64_t bytes() const;

  private:
    std::vector<TilePoints> layers_;
    tbb::enumerable_thread_specific<std::vector<TileCells>> cells_;
};

}  // namespace mote::render
