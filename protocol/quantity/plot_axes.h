// SPDX-License-Identifier: GPL-3.0-or-later
//
// The axes of a plot's step, with their bounds: those of the plot, or where each step has bounds of its own,
// the step's (docs/FORMAT.md). Pure functions.
#pragma once

#include <cstdint>

#include "protocol/mote.pb.h"

namespace mote {

constexpr int axesOfPlot = 3;

/// Whether the axes of each step stand behind the plot's, in their order, as datasets had them before a step
/// had its own.
inline bool stepsBehindAxes(const proto::ParticlesManifest& plot) {
    return plot.axes_size() > axesOfPlot && plot.axes_size() == axesOfPlot * (1 + plot.steps_size());
}

/// Axis 0, 1 or 2. The plot has three at least.
inline const proto::Axis& axisOf(const proto::ParticlesManifest& plot, int axis, std::uint32_t step) {
    if (step >= static_cast<std::uint32_t>(plot.steps_size())) return plot.axes(axis);
    const auto at = static_cast<int>(step);
    if (plot.steps(at).axes_size() == axesOfPlot) return plot.steps(at).axes(axis);
    return plot.axes(stepsBehindAxes(plot) ? axesOfPlot * (1 + at) + axis : axis);
}

}  // namespace mote
