// SPDX-License-Identifier: GPL-3.0-or-later
//
// OctreeLevels: an octree, or a part of one, as the job builds it: level by level, each in Morton order. A
// value.
#pragma once

#include <cstdint>
#include <vector>

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

}  // namespace mote::prep
