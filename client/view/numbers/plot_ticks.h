// SPDX-License-Identifier: GPL-3.0-or-later
//
// PlotTicks: where an axis of a plot has marks and what stands at them: round numbers in a prefix of the
// axis' unit. Pure functions.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "client/view/knot_curve.h"

namespace mote::client {

struct PlotTicks {
    std::vector<double> at;           ///< in the axis' unit, ascending
    std::vector<std::string> labels;  ///< as many, in the scaled unit
    std::string unit;                 ///< scaled: "mm"; empty: it has none
};

/// At most `most` of them, 1, 2 or 5 times a power of ten apart; none on an axis that is not finite or has no
/// extent.
PlotTicks ticksOf(const Interval& axis, std::string_view unit, int most);

/// "x [mm]"; the name alone where there is no unit.
std::string axisTitle(std::string_view name, std::string_view unit);

}  // namespace mote::client
