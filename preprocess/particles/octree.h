// SPDX-License-Identifier: GPL-3.0-or-later
//
// OctreeLevels: an octree, or a part of one, as the job builds it: level by level, each in Morton order.
// OctreePart: what one rank has of it. Octree: the nodes and leaves of a step, put together by all ranks, of
// which each holds some: one rank alone all. Values.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "preprocess/parallel/communicator.h"
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

/// A cell that is a leaf at or above the grid's level, or a cell of the grid that is divided further.
struct PlanUnit {
    std::uint8_t level = 0;
    bool divided = false;
    std::uint32_t count = 0;
    std::uint32_t index = 0;  ///< among the octree's nodes of its level
    std::uint64_t morton = 0;
};

/// What a unit of the plan turned out to be.
struct UnitTree {
    double weight = 0.0;        ///< of a leaf
    std::uint8_t children = 0;  ///< of a divided one, as in OctreeLevel
};

/// A rank's part of an octree: what lies in units that follow one another, and the levels that all ranks
/// know.
struct OctreePart {
    OctreeLevels top;    ///< down to the grid's level, of all ranks, as the plan has them; the root's first
    OctreeLevels below;  ///< below it, of this rank's units; as many levels on all ranks
    std::vector<PlanUnit> units;  ///< of all ranks, in Morton order
    std::size_t firstUnit = 0;    ///< of this rank's
    std::vector<UnitTree> found;  ///< of this rank's units
};

/// Nodes that stand one after another, here and in the file.
struct NodeRun {
    std::size_t first = 0;  ///< among those that this rank holds
    std::size_t count = 0;
    std::uint64_t place = 0;  ///< of the first among all nodes
    bool operator==(const NodeRun&) const = default;
};

/// What a rank holds of a step's octree. Its nodes are those of the levels that all ranks know, whole, and
/// below them those of its own units. Its leaves are a slice of all in their order, whoever has the points.
struct Octree {
    // Nodes, breadth first; as storage::OctreeNodes. Numbers of nodes and leaves are those among all.
    std::vector<std::uint8_t> level;
    std::vector<std::uint64_t> morton;
    std::vector<std::uint32_t> firstChild;  ///< of nodes in `runs`
    std::vector<std::uint8_t> childCount;
    std::vector<std::uint64_t> count;
    std::vector<float> density;
    std::vector<float> minDensity;
    std::vector<NodeRun> runs;    ///< of the nodes that are this rank's alone: each is some rank's
    std::uint64_t nodeTotal = 0;  ///< of all ranks

    // Leaves, ascending by density; as storage::Leaves.
    std::vector<std::uint32_t> leafNode;
    std::vector<std::uint64_t> leafPointBegin;
    std::vector<std::uint32_t> leafPointCount;
    std::vector<float> leafDensity;
    std::vector<std::uint32_t> leafSource;  ///< each leaf's first point among all points in Morton order
    std::vector<std::uint64_t> leafCell;    ///< cellCode() of its node
    std::uint64_t leafBefore = 0;           ///< leaves of the slices before
    std::uint64_t leafTotal = 0;            ///< of all ranks
    /// The first point of each rank's slice, and one more.
    std::vector<std::uint64_t> slicePoint;

    double totalWeight = 0.0;
    /// Of the densities of all leaves, but for those of zero (macro-particles may weigh nothing); empty if
    /// there is no other.
    Range leafDensities;
    /// The same, but that a density of few particles says little: of a leaf that holds fewer than `counted`,
    /// that of the smallest cell around it that holds as many, or of the whole plot, is taken.
    Range toldDensities;

    storage::OctreeNodes nodes() const;
    storage::Leaves leaves() const;
};
inline constexpr std::uint64_t counted = 64;  ///< particles, whose density is right to an eighth
/// Writing a leaf's points takes as long as writing so many points more, as they come from elsewhere.
inline constexpr std::uint64_t pointsPerLeaf = 8;

/// A cell's Morton key and its level in one number, in their order.
constexpr std::uint64_t cellCode(std::uint64_t morton, std::uint8_t level) {
    return morton << 8 | level;
}
constexpr std::uint64_t mortonOf(std::uint64_t cellCode) {
    return cellCode >> 8;
}
constexpr std::uint8_t levelOf(std::uint64_t cellCode) {
    return static_cast<std::uint8_t>(cellCode);
}

/// Puts the octree together, on all ranks, whose parts follow one another. Weights are summed in a fixed
/// order, so that all of the octree is the same for any number of ranks, and of threads of the calling arena;
/// only where slices begin is not. Errors: resourceExhausted (more nodes than 32 bits can name, a density
/// beyond single precision), cancelled; the same on all ranks.
Result<Octree> assembleOctree(OctreePart part, Communicator& ranks);

}  // namespace mote::prep
