// SPDX-License-Identifier: GPL-3.0-or-later
//
// An octree cell's integer place (storage/particles/octree_cell.h), by the names that plans use.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "storage/particles/octree_cell.h"

namespace mote::render {

using storage::cellPlace;
using storage::deepestLevel;
using storage::everyThirdBit;

/// The share of the plot that a cell of a level has, 8^-level; at most the deepest level.
inline double cellShare(unsigned level) {
    static const auto shares = [] {
        std::array<double, deepestLevel + 1> all{};
        for (int i = 0; i <= deepestLevel; ++i) all[static_cast<std::size_t>(i)] = std::ldexp(1.0, -3 * i);
        return all;
    }();
    return shares[level];
}

}  // namespace mote::render
