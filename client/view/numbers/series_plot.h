// SPDX-License-Identifier: GPL-3.0-or-later
//
// SeriesPlot: a statistic over the steps as lines, of all particles and of a selection; a click goes to a
// step. Main thread, inside a Dear ImGui window.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "client/view/knot_curve.h"

namespace mote::client {

struct SeriesPlot {
    std::string name, unit;            ///< of the statistic
    std::span<const double> whole;     ///< by step; NaN leaves a gap
    std::span<const double> selected;  ///< likewise; it may be shorter
    std::array<float, 3> color{};      ///< of the selection's line, sRGB-encoded
    std::uint32_t step = 0;            ///< that is shown
    float height = 0.0F;               ///< pixels
};

/// What the finite values of both span, with a little room; 0 to 1 where there is none.
Interval extentOf(std::span<const double> first, std::span<const double> second);

/// Draws it over the width that is left; the step that the user goes to.
std::optional<std::uint32_t> drawSeries(const SeriesPlot& plot);

}  // namespace mote::client
