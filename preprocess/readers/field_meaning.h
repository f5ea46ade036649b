// SPDX-License-Identifier: GPL-3.0-or-later
//
// FieldMeaning: which column of a run a named field of a table holds, and in which unit; and the units in
// which particles come out of the readers. Values and functions without state.
#pragma once

#include <numbers>
#include <optional>
#include <string>
#include <string_view>

#include "preprocess/constants.h"
#include "preprocess/readers/particle_source.h"
#include "protocol/base/error.h"

namespace mote::prep {

inline constexpr double radiansPerTurn = 2 * std::numbers::pi;

/// eV/c in one kg m/s.
inline constexpr double momentumInEv = speedOfLight / elementaryCharge;
/// eV/c^2 in one kg.
inline constexpr double massInEv = speedOfLight * speedOfLight / elementaryCharge;

inline constexpr double electronMass = 510998.95;  ///< eV/c^2, CODATA 2018

/// Rest mass in eV/c^2 of a species by its name, in any letter case: "electron", "H-", "#12C+3", ...; 0 of
/// photons. Nothing for a name that is not known.
std::optional<double> speciesMass(std::string_view name);

struct FieldMeaning {
    enum class Kind : std::uint8_t {
        column,  ///< of a run
        status,  ///< 1: live, anything else: lost
        beam,    ///< of openPMD's beam physics: 1 live, 0 at the cathode and live; anything else: lost
        lost,    ///< 0: live, anything else: lost
        alive,   ///< 0: lost, anything else: live
        record,  ///< the source's own, by its name
    };
    Kind kind = Kind::column;
    Column column = Column::x;
    double factor = 1.0;   ///< into the column's unit
    bool coulomb = false;  ///< of weights: they are charges
};

/// The meaning of a field's name, in any letter case, with a unit in brackets where it is not the column's
/// own: "x", "x [mm]", "px (MeV/c)", "weight", "particleStatus". `mass` (eV/c^2, 0: unknown) turns momenta in
/// units of m c into eV/c. Nothing for a name that is not known. Errors, at `where`: unsupported (an unknown
/// unit), invalidArgument (m c without a mass).
Result<std::optional<FieldMeaning>> fieldMeaning(std::string_view name, double mass,
                                                 const std::string& where);

/// What a field of no known meaning is: its name, and behind it in brackets its unit: "spin [hbar]". Nothing
/// where the name cannot be that of a record: it is long, or that of a known quantity.
std::optional<SourceRecord> recordOf(std::string_view name);

/// Whether a value of a status, lost or alive field says that the particle is lost.
inline bool saysLost(FieldMeaning::Kind kind, double value) {
    return kind == FieldMeaning::Kind::status ? value != 1.0
           : kind == FieldMeaning::Kind::beam ? value != 1.0 && value != 0.0
           : kind == FieldMeaning::Kind::lost ? value != 0.0
                                              : value == 0.0;
}

}  // namespace mote::prep
