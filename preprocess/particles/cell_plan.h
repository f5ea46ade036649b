// SPDX-License-Identifier: GPL-3.0-or-later
//
// CellPlan: what the numbers of particles in the cells of a grid say before any particle is sorted: the
// octree down to the grid's level, and ranges of cells, in Morton order, that can be sorted one by one. No
// leaf lies in two ranges. A value; the same for any number of ranks.
#pragma once

#include <cstdint>
#include <vector>

#include "preprocess/particles/octree_levels.h"

namespace mote::prep {

/// The level of the grid for a step of so many rows: finer for more, at most 7.
unsigned gridLevelFor(std::uint64_t rows);

/// A cell that is a leaf at or above the grid's level, or a cell of the grid that is divided further.
struct PlanUnit {
    std::uint8_t level = 0;
    bool divided = false;
    std::uint32_t count = 0;
    std::uint32_t index = 0;  ///< among the octree's nodes of its level
    std::uint64_t morton = 0;
};

/// Units that are sorted together.
struct PlanRange {
    std::size_t firstUnit = 0;
    std::size_t unitCount = 0;
    std::uint64_t begin = 0;  ///< particles before it, in Morton order
    std::uint64_t count = 0;  ///< particles
};

struct CellPlan {
    unsigned gridLevel = 0;
    OctreeLevels levels;  ///< down to the grid's; weights, and what divided units hold, are not yet known
    std::vector<PlanUnit> units;             ///< in Morton order
    std::vector<PlanRange> ranges;           ///< at least one, fewer than 2^16
    std::vector<std::uint16_t> rangeOfCell;  ///< by cell of the grid

    std::uint64_t particles() const { return ranges.back().begin + ranges.back().count; }
    std::uint64_t largestRange() const;
};

/// `counts`, by cell of the grid, are 8^gridLevel numbers.
CellPlan planCells(const std::vector<std::uint32_t>& counts, unsigned gridLevel,
                   const OctreeOptions& options);

}  // namespace mote::prep
