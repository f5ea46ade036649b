// SPDX-License-Identifier: GPL-3.0-or-later
//
// Answers to queries as values: what a server says of numbers is held to what was asked, and to itself,
// before anything is made of it. Values and pure functions; units as in docs/NUMBERS.md. Errors of all:
// corrupt.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "client/shared/connection.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::client {

struct StepStatistics {
    std::uint32_t step = 0;
    std::int64_t iteration = 0;
    double time = 0.0;  ///< s
    std::vector<std::string> names;
    std::vector<double> values;               ///< by name; NaN: not defined
    std::vector<double> sliceEdges;           ///< one more than slices, or none
    std::vector<std::vector<double>> slices;  ///< each by name
    std::vector<std::string> notes = {};      ///< what limits them, a sentence each
};
Result<StepStatistics> statisticsOf(const QueryAnswer& answer);

struct StepHistogram {
    std::uint32_t step = 0;
    std::vector<std::string> columns;        ///< one or two
    std::vector<std::vector<double>> edges;  ///< of each column, ascending, one more than bins
    std::vector<double> counts;              ///< of the second column fastest
    std::uint64_t particles = 0;             ///< that it rests on
    double outside = 0.0;                    ///< weight beyond the edges
    std::vector<std::string> notes = {};     ///< what limits it, a sentence each

    std::size_t bins(std::size_t column) const { return edges[column].size() - 1; }
};
/// `asked` says which columns, and how many bins they have.
Result<StepHistogram> histogramOf(const QueryAnswer& answer, const proto::HistogramQuery& asked);

/// A piece of a step's columns.
struct StepColumns {
    std::uint32_t step = 0;
    std::uint64_t count = 0;  ///< rows
    /// The columns by the names that were asked for: `count` words each, f64, of "id" u64.
    std::vector<std::vector<std::uint64_t>> words;
    std::vector<std::string> units;       ///< by name, or none
    std::uint64_t next = 0;               ///< where the next piece begins; over the one that was asked for
    bool end = false;                     ///< there is none
    std::uint64_t total = 0;              ///< by id: ids of the selection
    std::vector<std::string> notes = {};  ///< what limits them, a sentence each
};
Result<StepColumns> columnsOf(const QueryAnswer& answer, const proto::ColumnsQuery& asked);

/// Statistics of the whole steps, as a dataset has them. Errors: notFound, with how to make them: it was made
/// without.
Result<std::vector<StepStatistics>> statisticsOf(const proto::ParticlesManifest& manifest,
                                                 const std::vector<std::size_t>& steps);

// What the name of a statistic says (docs/NUMBERS.md): of which columns it is, and in which unit. Pure
// functions.

/// Units of columns and derived quantities by their names.
using ColumnUnits = std::map<std::string, std::string, std::less<>>;
ColumnUnits columnUnits(const proto::ParticlesManifest& manifest);

/// The unit of a column, a known quantity or an expression over such; "" if it is not known.
std::string unitOfColumn(std::string_view column, const ColumnUnits& units);

/// "x" and "px" of "cov_x__px", "x" of "norm_emit_x"; none of "n_particle".
std::vector<std::string> columnsOf(std::string_view statistic);

/// "m", "eV/c", "m eV/c", "1"; "" if it is not known.
std::string unitOf(std::string_view statistic, const ColumnUnits& units);

/// "x [m]", as heads of tables have it; the name alone if the unit is not known, or 1 unless that is
/// `told` too.
std::string withUnit(std::string_view name, std::string_view unit, bool told = false);

// Numbers and names as files and terminals have them. Pure functions.

/// Writes as few digits as give the same double again; `undefined` where it is not finite.
std::string exactNumber(double value, std::string_view undefined);

/// A field of a line of comma-separated values (RFC 4180).
std::string csvField(std::string_view text);

/// A number for people, in a prefix of its unit.
struct ScaledUnit {
    double scale = 1.0;  ///< of one scaled unit, in the unit
    std::string name;    ///< "mm"
};

/// The unit with the SI prefix in which `magnitude` is 1 to 1000. Units that are no plain ones (m^2, 1/m, 1)
/// have no prefix, and neither has what is zero or not finite.
ScaledUnit scaledUnit(double magnitude, std::string_view unit);

/// Writes a value in that unit, five digits; "-" where it is not finite.
std::string shortNumber(double value, const ScaledUnit& unit);

/// How many columns of a terminal a text takes that is of letters alone.
std::size_t widthOf(std::string_view text);
/// The text with blanks before or behind it until it is that wide.
std::string padLeft(std::string_view text, std::size_t width);
std::string padRight(std::string_view text, std::size_t width);

}  // namespace mote::client
