// SPDX-License-Identifier: GPL-3.0-or-later
//
// OctreeLevels: an octree, or a part of one, as the job builds it: level by level, each in Morton order.
// Octree: the nodes and leaves of a step, put together from them. Values.
#pragma once

#include <cstdint>
#include <vector>

#include "preprocess/particles/bounds_rule.h"
#include "protocol/base/error.h"
#include "storage/particles/particle_step.h"

namespace mote::prep {

struct OctreeOptions {
    std::uint32_t leafCapacity = 0;  ///< a cell with more particles is divided, down to maxLevel
    std::uint32_t maxLevel = 0;      ///< at most 16
};

struct OctreeLevel {
    std::vector<std::uint8_t> children;  ///< bit i: child i holds particles; 0: a leaf
    std::vector<std::uint32_t> count;    ///< particles
    std::vector<double> weight;          ///< of a leaf's particles; an inner node's is not yet summed

    std::size_t size() const { return count.size(); }
    void add(std::uint32_t particles) {
        children.push_back(0);
        count.push_back(particles);
        weight.push_back(0.0);
    }
};

using OctreeLevels = std::vector<OctreeLevel>;

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

/// The range of the densities of leaves, but for those of zero (macro-particles may weigh nothing); empty
/// if there is no other. A density of few particles says little: of a leaf that holds fewer than
/// `counted`, that of the smallest cell around it that holds as many, or of the whole plot, is taken.
Range densityRange(const Octree& tree);
inline constexpr std::uint64_t counted = 64;  ///< particles, whose density is right to an eighth

/// Assembles the octree from all levels, the root's first. Weights are summed in a fixed order: the result is
/// the same for any number of threads of the calling arena. Errors: resourceExhausted (more nodes than 32
/// bits can name, a density beyond single precision).
Result<Octree> assembleOctree(OctreeLevels levels);

}  // namespace mote::prep
