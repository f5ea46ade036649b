// SPDX-License-Identifier: GPL-3.0-or-later
//
// Particle records as openPMD 1.1 and its beam physics extension have them, for files that we write.
// Functions return false if HDF5 refuses; H5Errors then says why. One thread at a time.
#pragma once

#include <array>
#include <cstdint>

#include "preprocess/constants.h"
#include "preprocess/openpmd/h5_output.h"

namespace mote::prep {

inline constexpr std::array<const char*, 3> axisNames{"x", "y", "z"};
inline constexpr double electronvoltOverC = elementaryCharge / speedOfLight;  ///< kg m/s

/// What openPMD asks of a record: powers of m, kg, s, A, K, mol, cd; how values scale with a macro-particle's
/// weight.
struct RecordKind {
    const char* name;
    std::array<double, 7> dimension;
    std::uint32_t macroWeighted;
    double weightingPower;
};

namespace records {
inline constexpr RecordKind position{"position", {1, 0, 0, 0, 0, 0, 0}, 0, 0.0};
inline constexpr RecordKind positionOffset{"positionOffset", {1, 0, 0, 0, 0, 0, 0}, 0, 0.0};
inline constexpr RecordKind momentum{"momentum", {1, 1, -1, 0, 0, 0, 0}, 0, 1.0};
inline constexpr RecordKind time{"time", {0, 0, 1, 0, 0, 0, 0}, 0, 0.0};
inline constexpr RecordKind mass{"mass", {0, 1, 0, 0, 0, 0, 0}, 0, 1.0};
inline constexpr RecordKind charge{"charge", {0, 0, 1, 1, 0, 0, 0}, 0, 1.0};
inline constexpr RecordKind weighting{"weighting", {0, 0, 0, 0, 0, 0, 0}, 1, 1.0};
/// Of the beam physics extension: the charge of a macro-particle.
inline constexpr RecordKind weight{"weight", {0, 0, 1, 1, 0, 0, 0}, 1, 1.0};
/// Of the beam physics extension: 1 of those that are not lost.
inline constexpr RecordKind status{"particleStatus", {0, 0, 0, 0, 0, 0, 0}, 0, 0.0};
inline constexpr RecordKind identity{"id", {0, 0, 0, 0, 0, 0, 0}, 0, 0.0};
}  // namespace records

/// The attributes of a record, on its group or, of a scalar, its dataset.
bool describeRecord(hid_t record, const RecordKind& kind);

/// Makes a group a component that has one value, `rows` times.
bool setConstant(hid_t component, double value, double unit, std::uint64_t rows);
/// A scalar record of one value.
bool addConstantScalar(hid_t species, const RecordKind& kind, double value, std::uint64_t rows);
/// A scalar record with a column that is to be written.
bool addScalar(hid_t species, const RecordKind& kind, hid_t type, double unit, std::uint64_t rows);

}  // namespace mote::prep
