// SPDX-License-Identifier: GPL-3.0-or-later
//
// StepNeed: what of a step a picture would use if it were in memory. A value; the plan makes it, StepLoader
// brings it in: preview, volume, octree, then the points, the ranges in their order.
#pragma once

#include <cstdint>
#include <vector>

namespace mote::storage {

struct PointRange {
    std::uint64_t begin = 0;  ///< in the order of the leaves
    std::uint64_t count = 0;
    bool operator==(const PointRange&) const = default;
};

struct StepNeed {
    std::uint64_t preview = 0;            ///< points of it, from the first
    bool volume = false;                  ///< all of it
    bool octree = false;                  ///< octree and leaves, whole and checked
    std::vector<PointRange> points = {};  ///< the most urgent first

    bool empty() const { return preview == 0 && !volume && !octree && points.empty(); }
    bool operator==(const StepNeed&) const = default;
};

}  // namespace mote::storage
