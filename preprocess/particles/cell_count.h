// SPDX-License-Identifier: GPL-3.0-or-later
//
// CellCount: how many particles of a step lie in each cell of a grid, and what else one pass over them tells.
// A value.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "preprocess/particles/bounds_rule.h"
#include "preprocess/particles/step_reader.h"

namespace mote::prep {

struct CellCount {
    std::vector<std::uint32_t> cells;  ///< by cell of the grid, by Morton key
    std::uint64_t lost = 0, invalid = 0, outside = 0;
    Range weight;  ///< of the particles within the bounds

    void add(const CellCount& other);
};

/// Counts the particles of this rank's blocks. Errors: the source's own, cancelled.
Result<CellCount> countCells(StepReader& reader, const std::array<Range, 3>& bounds, unsigned gridLevel);

/// The sum of all ranks'.
Result<CellCount> sumOfRanks(Communicator& ranks, const CellCount& mine);

}  // namespace mote::prep
