// SPDX-License-Identifier: GPL-3.0-or-later
//
// The axes of a plot's step, with their bounds: those of the plot, or where each step has bounds of its own,
// the step's (docs/FORMAT.md). Pure functions.
#pragma once

#include <cstdint>

#include "protocol/mote.pb.h"

namespace mote {

constexpr int axesOfPlot = 3;

/// Whether each step has bounds of its own: behind the plot's axes stand those of each step, in their order.
inline bool boundsOfSteps(const proto::ParticlesManifest& plot) {
    return plot.axes_size() > axesOfPlot && plot.axes_size() == axesOfPlot * (1 + plot.steps_size());
}

/// Axis 0, 1 or 2. The plot has three at least.
inline const proto::Axis& axisOf(const proto::ParticlesManifest& plot, int axis, std::uint32_t step) {
    const bool own = boundsOfSteps(plot) && step < static_cast<std::uint32_t>(plot.steps_size());
    return plot.axes(own ? axesOfPlot * (1 + static_cast<int>(step)) + axis : axis);
}

}  // namespace mote
