// SPDX-License-Identifier: GPL-3.0-or-later
//
// Octree: the nodes and leaves of a step while the job works, and how they are put together from their parts.
// A value.
#pragma once

#include <cstdint>
#include <vector>

#include "preprocess/particles/octree_levels.h"
#include "protocol/scene/error.h"
#include "storage/particles/particle_step.h"

namespace mote::prep {

struct Octree {
    // Nodes, breadth first; as storage::OctreeNodes.
    std::vector<std::uint8_t> level;
    std::vector<std::uint64_t> morton;
    std::vector<std::uint32_t> firstChild;
    std::vector<std::uint8_t> childCount;
    std::vector<std::uint64_t> count;
    std::vector<float> density;
    std::vector<float> minDensity;
    // Leaves, ascending by density; as storage::Leaves.
    std::vector<std::uint32_t> leafNode;
    std::vector<std::uint64_t> leafPointBegin;
    std::vector<std::uint32_t> leafPointCount;
    std::vector<float> leafDensity;
    /// Each leaf's first point among all points in Morton order.
    std::vector<std::uint64_t> leafSource;
    double totalWeight = 0.0;

    storage::OctreeNodes nodes() const;
    storage::Leaves leaves() const;
};

/// Assembles the octree from all levels, the root's first. Weights are summed in a fixed order: the result is
/// the same for any number of threads of the calling arena. Errors: resourceExhausted (more nodes than 32
/// bits can name, a density beyond single precision).
Result<Octree> assembleOctree(OctreeLevels levels);

}  // namespace mote::prep
