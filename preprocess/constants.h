// SPDX-License-Identifier: GPL-3.0-or-later
//
// Constants of nature that units are made of (SI, exact), and of geometry.
#pragma once

#include <numbers>

namespace mote::prep {

inline constexpr double speedOfLight = 299'792'458.0;        ///< m/s
inline constexpr double elementaryCharge = 1.602176634e-19;  ///< C

/// Radians from one ring particle to the next, so that few or many lie evenly around (Vogel's spiral).
inline constexpr double goldenAngle = std::numbers::pi * (3.0 - 2.23606797749978969641);

}  // namespace mote::prep
