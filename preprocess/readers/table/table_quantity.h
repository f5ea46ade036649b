// SPDX-License-Identifier: GPL-3.0-or-later
//
// TableQuantity: what a named field of a table is, the columns of a run among them, and the units in which
// people write it. Values and functions without state.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/unit_names.h"
#include "protocol/base/error.h"

namespace mote::prep {

enum class TableQuantity : std::uint8_t {
    x,
    y,
    z,  ///< m
    t,  ///< s
    px,
    py,
    pz,      ///< eV/c
    weight,  ///< as Column::weight
    id,
    status,             ///< 1: live
    beamStatus,         ///< 1: live, 0: at the cathode and live
    state,              ///< 1 and above: live, as xsuite counts
    lost,               ///< 0: live
    alive,              ///< 0: lost
    slopeX,             ///< px / pz
    slopeY,             ///< py / pz
    momentum,           ///< the whole, eV/c
    referenceMomentum,  ///< eV/c
    mass,               ///< eV/c^2
    zeta,               ///< m, how far a particle is ahead: s - beta0 c t
    late,               ///< m, c times the time by which it comes after the reference particle
    delta,              ///< (p - p0) / p0
    energyDeviation,    ///< (E - E0) / (p0 c)
    scaledDeviation,    ///< the same over beta0
    gamma,              ///< Lorentz factor
    kineticEnergy,      ///< eV
    totalEnergy,        ///< eV
    velocityX,
    velocityY,
    velocityZ,  ///< c
    chi,        ///< q / q0 over m / m0
    chargeRatio,
    chargeNumber,       ///< charge of one particle, in elementary charges
    radius,             ///< m
    radialMomentum,     ///< eV/c
    azimuthalMomentum,  ///< eV/c
};
inline constexpr std::size_t tableQuantityCount = 36;

struct TableMeaning {
    TableQuantity quantity = TableQuantity::x;
    double factor = 1.0;    ///< into the quantity's unit
    bool relative = false;  ///< a momentum in units of the reference momentum
    bool inMass = false;    ///< in units of the mass: `factor` is still to be multiplied by it
    bool unitGiven = true;  ///< false: `factor` is of the unit that is assumed
    bool charge = false;    ///< a weight that is a charge
};

/// The meaning of a field's name, in any letter case, with its unit behind it: "x", "x [mm]", "px(MeV/c)",
/// "x_mm", "x/mm". Nothing for a name that is not known. Error, at `where`: unsupported (a unit in brackets
/// that is not known).
Result<std::optional<TableMeaning>> tableMeaning(std::string_view name, const std::string& where);

/// The quantity of a name in lower case and without a unit: what every reader of named fields goes by.
std::optional<TableQuantity> quantityNamed(std::string_view name);
/// The units in which a quantity is written, and their factors.
std::span<const Unit> unitsOf(TableQuantity quantity);
/// Whether a momentum in the unit is in units of m c; as unitName has it.
bool isMassUnit(std::string_view unit);

/// Whether the text is a unit of any quantity, in brackets or not: "[mm]", "MeV/c".
bool isTableUnit(std::string_view text);

/// "m", "eV/c", ...: the unit that is assumed where none is written; "" where there is nothing to assume.
std::string_view assumedUnit(TableQuantity quantity);

/// All names before a '=' of --map, for messages.
std::string tableQuantityNames();

}  // namespace mote::prep
