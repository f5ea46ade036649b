// SPDX-License-Identifier: GPL-3.0-or-later
//
// The waterbag: points spread evenly in the six-dimensional unit ball, one a particle, each a function of the
// seed and its index alone. Pure functions.
#pragma once

#include <array>
#include <cstdint>

namespace mote::prep {

/// Three planes (u, u'): even in the unit ball of six dimensions, where every coordinate has mean square 1/8.
std::array<std::array<double, 2>, 3> waterbagPoint(std::uint64_t seed, std::uint64_t particle);

}  // namespace mote::prep
