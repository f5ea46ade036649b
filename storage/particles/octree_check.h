// SPDX-License-Identifier: GPL-3.0-or-later
//
// Whether octree and leaves are what docs/FORMAT.md says: one tree, breadth first, whose leaves divide the
// points. What passes can be traversed and drawn without further checks. A pure function, one pass over nodes
// and leaves.
#pragma once

#include <cstdint>

#include "protocol/base/error.h"
#include "storage/particles/particle_step.h"

namespace mote::storage {

/// Errors: corrupt, with the array and index.
Status checkOctree(const OctreeNodes& nodes, const Leaves& leaves, std::uint64_t points,
                   std::uint32_t maxLevel);

}  // namespace mote::storage
