// SPDX-License-Identifier: GPL-3.0-or-later
//
// The moves of a hierarchy as its builders record them, in the order in which they are made. Owned by a
// builder; one thread.
#pragma once

#include <cstdint>
#include <deque>
#include <glm/vec3.hpp>

#include "storage/stipple/stipple_hierarchy.h"

namespace mote::prep {

struct RecordedMove {
    std::uint32_t point;
    std::uint32_t neighbour;  ///< the removed point that caused it
    glm::vec3 position;       ///< where it leads, world units
};

using RecordedMoves = std::deque<RecordedMove>;  ///< grows without being copied

/// Puts them into a hierarchy that has its points, by point, each point's in their order.
void storeMoves(const RecordedMoves& moves, storage::StippleHierarchy& hierarchy);

}  // namespace mote::prep
