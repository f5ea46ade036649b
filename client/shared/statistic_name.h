// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the name of a statistic says (docs/NUMBERS.md): of which columns it is, and in which unit. Pure
// functions.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/mote.pb.h"

namespace mote::client {

/// Units of columns and derived quantities by their names.
using ColumnUnits = std::map<std::string, std::string, std::less<>>;
ColumnUnits columnUnits(const proto::ParticlesManifest& manifest);

/// Of a column, a known quantity or an expression over such; "" where it is not known.
std::string unitOfColumn(std::string_view column, const ColumnUnits& units);

/// "x" and "px" of "cov_x__px", "x" of "norm_emit_x"; none of "n_particle".
std::vector<std::string> columnsOf(std::string_view statistic);

/// "m", "eV/c", "m eV/c", "1"; "" where it is not known.
std::string unitOf(std::string_view statistic, const ColumnUnits& units);

/// "x [m]", as heads of tables have it; the name alone where the unit is not known, or 1 unless that is
/// `told` too.
std::string withUnit(std::string_view name, std::string_view unit, bool told = false);

}  // namespace mote::client
