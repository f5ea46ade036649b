// SPDX-License-Identifier: GPL-3.0-or-later
//
// How the histogram of a step is told: a line of JSON, comma-separated values, or a picture of letters for
// people. Pure functions.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "client/shared/numbers.h"
#include "client/shared/statistic_name.h"

namespace mote::client {

/// One line, with its end: {"step", "edges", "counts", "particles", "outside"}.
std::string jsonLine(const StepHistogram& histogram);
/// The line that names the fields, with their units, for columns of that name.
std::string csvHead(const std::vector<std::string>& columns, const ColumnUnits& units);
/// A line for each bin: the step, where it begins and ends, its count.
std::string csvText(const StepHistogram& histogram);
/// As many bins as a picture has room for, of each column.
std::array<std::uint32_t, 2> shownBins(std::size_t columns);
/// Of one column a line for each bin, of two a shaded field: where there are more than can be shown, some are
/// put together. For a terminal.
std::string pictureText(const StepHistogram& histogram, const ColumnUnits& units);

}  // namespace mote::client
