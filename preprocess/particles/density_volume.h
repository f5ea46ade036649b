// SPDX-License-Identifier: GPL-3.0-or-later
//
// The density volume of a step, counted from its sorted particles. A pure function.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace mote::prep {

/// The densities of the 8^level cells of an octree level, x fastest: weight over the cell's share of the box.
/// Keys as in buildOctree, keyLevel at least `level`. Each cell is summed in the order of its particles,
/// whatever the number of threads of the calling arena.
std::vector<float> densityVolume(std::span<const std::uint64_t> keys, std::span<const double> weights,
                                 unsigned keyLevel, unsigned level);

}  // namespace mote::prep
