// SPDX-License-Identifier: GPL-3.0-or-later
//
// Constants of nature that units are made of (SI, exact).
#pragma once

namespace mote::prep {

inline constexpr double speedOfLight = 299'792'458.0;        ///< m/s
inline constexpr double elementaryCharge = 1.602176634e-19;  ///< C

}  // namespace mote::prep
