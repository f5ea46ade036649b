// SPDX-License-Identifier: GPL-3.0-or-later
//
// PointGroups: the points that a plan selects from the leaves, brought together by cells of the octree that
// hold some hundred of them each. Leaves lie in the file by their density, so neighbours lie far apart, and
// those that are drawn at rest draw a few points each: a picture of groups places one cell for many leaves
// and reads points one after another. Immutable; shared by the pictures that are drawn of them.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "server/render/cpu/leaf_cells.h"
#include "server/render/cpu/points_kernel.h"
#include "server/render/plan/frame_plan.h"

namespace mote::render {

struct PointGroups {
    std::vector<LeafPoints> groups;    ///< cells of the octree, with their points; by parts of the box
    std::vector<GroupedPoint> points;  ///< by group, and sparePoints more
    /// By point, as many: its level (DensityLevels), if points are coloured by density.
    std::vector<std::uint8_t> levels;

    std::uint64_t bytes() const {
        return groups.capacity() * sizeof(LeafPoints) + points.capacity() * sizeof(GroupedPoint) +
               levels.capacity();
    }

    /// More are left to their leaves, also of all selections that are kept: 9 bytes a point, 72 MiB.
    static constexpr std::uint64_t mostPoints = std::uint64_t{1} << 23;
    /// Whether a picture of a layer is drawn from groups: at rest, of points that weigh alike, of a box that
    /// is not so large on the screen that single precision would tell the places in a group's cell worse than
    /// in a leaf's.
    static bool serve(const FramePlan& plan, const PointsPlan& layer, const PointMap& map);
};

/// Brings the points of a layer's selection together, on all threads of the calling arena, in turns
/// (plan/in_turns.h). The same for any number of threads. Null if `stop` was requested meanwhile. Throws
/// storage::StorageError.
std::shared_ptr<const PointGroups> groupPoints(const PointsPlan& layer, std::span<const LeafCell> cells,
                                               const std::stop_token& stop);

/// The groups of the selections in use, the latest few. Holds no selection alive. Owned by the device; one
/// thread at a time.
class ResidentGroups {
  public:
    /// Null if `stop` was requested meanwhile. Throws as groupPoints.
    std::shared_ptr<const PointGroups> of(const PointsPlan& layer, std::span<const LeafCell> cells,
                                          const std::stop_token& stop);
    void dropExpired();

  private:
    struct Entry {
        std::weak_ptr<const PointSelection> selection;
        std::shared_ptr<const PointGroups> groups;
    };
    std::list<Entry> entries_;  // the latest first
};

}  // namespace mote::render
