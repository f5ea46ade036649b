// SPDX-License-Identifier: GPL-3.0-or-later
//
// Tone as a drawing adds it up: independent layers of ink that cover shares a and b of the paper leave
// (1 - a)(1 - b) of it bare, so their densities -ln(1 - share) add. Pure.
#pragma once

#include <algorithm>
#include <cmath>

namespace mote::render {

/// As dark as anything is wanted.
inline constexpr double mostCover = 0.98;

inline double densityOf(double cover) {
    return -std::log(1.0 - std::clamp(cover, 0.0, mostCover));
}

inline double coverOf(double density) {
    return 1.0 - std::exp(-density);
}

}  // namespace mote::render
