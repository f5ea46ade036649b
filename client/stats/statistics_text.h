// SPDX-License-Identifier: GPL-3.0-or-later
//
// How statistics of steps are told: a line of JSON a step, comma-separated values, a NumPy file, or a table
// for people. Of at least one step; all have the same names. Pure functions, but for the file.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "client/shared/numbers.h"
#include "protocol/base/error.h"

namespace mote::client {

using StatisticsOfSteps = std::vector<StepStatistics>;

/// Returns those of `names` that are of these columns alone, and those that are of none, by their place.
std::vector<std::size_t> namesOfColumns(const std::vector<std::string>& names,
                                        const std::vector<std::string>& columns);
/// "mean_Q", "sigma_Q", "min_Q" and "max_Q" of those columns of which none of `names` is.
std::vector<std::string> furtherNames(const std::vector<std::string>& names,
                                      const std::vector<std::string>& columns);
/// Returns these alone, of slices too.
StepStatistics someOf(const StepStatistics& all, const std::vector<std::size_t>& places);

// `along`: the column along which slices lie; "": there are none. With slices, a row is a slice: its step,
// its number, and from where to where it reaches ("z_from", "z_to").

/// One line, with its end; of slices "slice_edges", and in "slices" a list of each statistic.
std::string jsonLine(const StepStatistics& statistics);
/// All lines, the first with the names and their units: "sigma_x [m]".
std::string csvText(const StatisticsOfSteps& steps, const ColumnUnits& units, const std::string& along = {});
/// Writes a structured array, whose fields have titles with units. Errors: those of the system.
Status writeNpy(const std::filesystem::path& path, const StatisticsOfSteps& steps, const ColumnUnits& units,
                const std::string& along = {});

/// Writes for a terminal all of one step, a line each; of several steps, or of a step's slices, a line each
/// of the usual ones.
std::string tableText(const StatisticsOfSteps& steps, const ColumnUnits& units,
                      const std::string& along = {});

// How the histogram of a step is told: a line of JSON, comma-separated values, or a picture of letters for
// people. Pure functions.

/// One line, with its end: {"step", "edges", "counts", "particles", "outside"}.
std::string jsonLine(const StepHistogram& histogram);
/// The line that names the fields, with their units, for columns of that name.
std::string csvHead(const std::vector<std::string>& columns, const ColumnUnits& units);
/// A line for each bin: the step, where it begins and ends, its count.
std::string csvText(const StepHistogram& histogram);
/// Returns as many bins of each column as a picture has room for.
std::array<std::uint32_t, 2> shownBins(std::size_t columns);
/// Writes a line for each bin of one column, of two a shaded field: where there are more than can be shown,
/// some are put together. For a terminal.
std::string pictureText(const StepHistogram& histogram, const ColumnUnits& units);

}  // namespace mote::client
