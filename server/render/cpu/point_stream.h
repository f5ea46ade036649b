// SPDX-License-Identifier: GPL-3.0-or-later
//
// PointStream: the points that a plan selects from the leaves, told in the whole box, so that a view in
// motion streams them and does not look at a leaf again while its selection stays. Their places are rounded
// to a 65536th of the box: for pictures in motion that show a box of no more than some thousand pixels. Owned
// by the device.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "server/render/cpu/leaf_cells.h"
#include "server/render/cpu/point_map.h"
#include "server/render/cpu/points_kernel.h"
#include "server/render/plan/frame_plan.h"

namespace mote::render {

class PointStream {
  public:
    /// A stream takes 8 bytes a point.
    static constexpr std::uint64_t mostPoints = std::uint64_t{1} << 25;

    /// Whether a picture of a layer is well drawn from a stream: not exact, of a plot that lies mostly in
    /// view, and whose box is not too large on the screen.
    static bool serves(const FramePlan& plan, const PointsPlan& layer, const PointMap& map);

    /// The layer's points, with their levels in place of densities; kept until another selection is asked
    /// for. Uses all threads of the calling arena. Throws storage::StorageError.
    std::span<const storage::PreviewPoint> of(const PointsPlan& layer, std::span<const LeafCell> cells);

  private:
    std::weak_ptr<const PointSelection> selection_;
    std::vector<storage::PreviewPoint> points_;
};

/// PreviewBlocks: points whose places are told in the whole box, block by block, as the kernels want them: of
/// a layer's preview, or streamed from its leaves. Shares what the plan, its step or the stream hold; read by
/// any number of threads.
class PreviewBlocks {
  public:
    static constexpr std::size_t blockPoints = storage::Preview::blockPoints;

    /// No blocks where the layer has no preview. Throws storage::StorageError.
    explicit PreviewBlocks(const PointsPlan& layer);
    /// All of `points`, which are streamed.
    explicit PreviewBlocks(std::span<const storage::PreviewPoint> points);
    /// None.
    PreviewBlocks() = default;

    std::size_t points() const { return points_.size(); }
    std::size_t count() const { return (points_.size() + blockPoints - 1) / blockPoints; }
    PreviewRun block(std::size_t index) const;

  private:
    const PreviewSelection* selection_ = nullptr;  // null: all
    std::span<const storage::PreviewPoint> points_;
    std::span<const float> threshold_;
    LevelLine levels_;
};

}  // namespace mote::render
