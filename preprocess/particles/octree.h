// SPDX-License-Identifier: GPL-3.0-or-later
//
// Octree: the nodes and leaves of a step while the job works, and their construction from sorted particles. A
// value.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "protocol/scene/error.h"
#include "storage/particles/particle_step.h"

namespace mote::prep {

struct OctreeOptions {
    std::uint32_t leafCapacity = 0;  ///< a cell with more particles is divided, down to maxLevel
    std::uint32_t maxLevel = 0;      ///< at most 16
};

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
    /// By leaf: where its particles begin among the sorted ones.
    std::vector<std::uint64_t> leafSource;
    double totalWeight = 0.0;

    storage::OctreeNodes nodes() const;
    storage::Leaves leaves() const;
};

/// From particles sorted by Morton key at `keyLevel` (at least maxLevel), and their weights in that order.
/// Without particles: a root that is a leaf of none. Weights are summed in a fixed order: the result is the
/// same for any number of threads of the calling arena. Errors: resourceExhausted (more nodes than 32 bits
/// can name, a density beyond single precision).
Result<Octree> buildOctree(std::span<const std::uint64_t> keys, std::span<const double> weights,
                           unsigned keyLevel, const OctreeOptions& options);

}  // namespace mote::prep
