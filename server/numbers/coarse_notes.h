// SPDX-License-Identifier: GPL-3.0-or-later
//
// What limits numbers of few particles: columns are held as floats about an offset, in steps (docs/FORMAT.md)
// that are fine beside the spread of a whole step, and perhaps not beside that of what was asked for. A
// sentence for each such column. Functions without state.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "storage/numbers/point_statistics.h"
#include "storage/particles/particle_columns.h"

namespace mote::server {

/// A spread of fewer steps is told of.
inline constexpr double fewestSteps = 100.0;
/// Bins narrower than so many steps, whose counts differ for that alone.
inline constexpr double fewestStepsOfBin = 10.0;

/// Of statistics of these names (none: all), of the points or of the slices.
std::vector<std::string> notesOfStatistics(const storage::ParticleColumns& columns,
                                           const storage::PointStatistics& found,
                                           std::span<const std::string> names);

/// Of bins of a column or derived quantity, by their edges.
std::vector<std::string> notesOfBins(const storage::ParticleColumns& columns, const std::string& column,
                                     std::span<const double> edges);

/// Of values of a column.
std::vector<std::string> notesOfValues(const storage::ParticleColumns& columns, const std::string& column,
                                       std::span<const double> values);

}  // namespace mote::server
