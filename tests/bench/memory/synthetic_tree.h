// SPDX-License-Identifier: GPL-3.0-or-later
//
// SyntheticTree: octree and leaves of a beam that nobody ever sampled: each cell's particles are shared out
// among its children by their masses, so the tree costs what it holds and not what its particles would. A
// value, made once.
#pragma once

#include <cstdint>
#include <vector>

#include "storage/particles/particle_step.h"
#include "tests/bench/memory/cell_mass.h"

namespace mote::bench {

struct SyntheticTree {
    static constexpr unsigned maxLevel = 10;
    static constexpr std::uint32_t leafCapacity = 32;

    /// Cells with more than leafCapacity of the `points` are divided down to maxLevel.
    SyntheticTree(std::uint64_t points, std::uint64_t seed);

    storage::OctreeNodes nodes() const;
    storage::Leaves leaves() const;

    std::vector<std::uint8_t> level;
    std::vector<std::uint64_t> morton;
    std::vector<std::uint32_t> firstChild;
    std::vector<std::uint8_t> childCount;
    std::vector<std::uint64_t> count;
    std::vector<float> density;
    std::vector<float> minDensity;
    std::vector<std::uint32_t> leafNode;
    std::vector<std::uint64_t> leafBegin;
    std::vector<std::uint32_t> leafCount;
    std::vector<float> leafDensity;

  private:
    void divide(std::size_t node, const CellMass& mass, std::uint64_t seed);
    void add(std::uint8_t nodeLevel, std::uint64_t code, std::uint64_t particles);
    void sortLeaves();
    void findLeast();
};

/// splitmix64 (Steele, Lea, Flood 2014).
inline std::uint64_t mixed(std::uint64_t h) {
    h += 0x9e3779b97f4a7c15ULL;
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ULL;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebULL;
    return h ^ (h >> 31);
}

}  // namespace mote::bench
