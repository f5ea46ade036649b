// SPDX-License-Identifier: GPL-3.0-or-later
//
// A synthetic turbulent bubble, in the manner of the argon bubble of section 3.2.3.1 of the dissertation: a
// ball of gas whose hull is torn by turbulence of many scales, dense in thin sheets and thin elsewhere. Pure;
// the same on every machine up to the last bits of floats.
#pragma once

#include <cstdint>

namespace mote::bench {

/// The value at a place in [-1, 1]^3, 0 to 1.
float bubble(float x, float y, float z);

}  // namespace mote::bench
