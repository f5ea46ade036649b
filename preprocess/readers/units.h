// SPDX-License-Identifier: GPL-3.0-or-later
//
// The units in which particles come out of the readers, and what SI units are in them. Constants, no state.
#pragma once

#include <numbers>
#include <optional>
#include <string_view>

namespace mote::prep {

inline constexpr double speedOfLight = 299792458.0;          ///< m/s, exact
inline constexpr double elementaryCharge = 1.602176634e-19;  ///< C, exact
inline constexpr double radiansPerTurn = 2 * std::numbers::pi;

/// eV/c in one kg m/s.
inline constexpr double momentumInEv = speedOfLight / elementaryCharge;
/// eV/c^2 in one kg.
inline constexpr double massInEv = speedOfLight * speedOfLight / elementaryCharge;

inline constexpr double electronMass = 510998.95;  ///< eV/c^2, CODATA 2018

/// Rest mass in eV/c^2 of a species by its name, in any letter case: "electron", "H-", "proton", ... (CODATA
/// 2018). Nothing for a name that is not known.
std::optional<double> speciesMass(std::string_view name);

}  // namespace mote::prep
