// SPDX-License-Identifier: GPL-3.0-or-later
//
// An octree cell's integer place (storage/particles/octree_cell.h), by the names that plans use.
#pragma once

#include "storage/particles/octree_cell.h"

namespace mote::render {

using storage::cellPlace;
using storage::deepestLevel;
using storage::everyThirdBit;

}  // namespace mote::render
