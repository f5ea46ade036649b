// SPDX-License-Identifier: GPL-3.0-or-later
//
// StepParticles: the particles of one step that take part in a plot, with their three plot coordinates. A
// value.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "preprocess/particles/plot_axis.h"

namespace mote::prep {

/// Rows that a step may have: a particle's row is kept in 32 bits while the job works.
inline constexpr std::uint64_t maxStepRows = (std::uint64_t{1} << 32) - 2;

struct StepParticles {
    std::array<std::vector<double>, 3> coordinate;  ///< by axis of the plot, in its unit; finite
    std::vector<double> weight;                     ///< finite, >= 0
    std::vector<std::uint32_t> row;                 ///< in the source, ascending
    std::uint64_t lost = 0;                         ///< marked as lost by the source
    std::uint64_t invalid = 0;  ///< not lost, but a coordinate is not finite or the weight is no weight

    std::size_t size() const { return row.size(); }
    /// Of the arrays.
    std::uint64_t bytes() const { return size() * (4 * sizeof(double) + sizeof(std::uint32_t)); }
};

using PlotAxes = std::array<PlotAxis, 3>;

/// Reads a whole step. Errors: the source's own, cancelled, resourceExhausted (too many rows).
Result<StepParticles> loadStep(ParticleSource& source, std::size_t step, const PlotAxes& axes,
                               Progress& progress);

}  // namespace mote::prep
