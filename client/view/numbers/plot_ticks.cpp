// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/numbers/plot_ticks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "client/shared/number_text.h"

namespace mote::client {
namespace {

/// The least round distance of which at most `most` fit into `extent`.
double spacingOf(double extent, int most) {
    const double least = extent / most;
    const double power = std::pow(10.0, std::floor(std::log10(least)));
    for (const double factor : {1.0, 2.0, 5.0}) {
        if (factor * power >= least) return factor * power;
    }
    return 10.0 * power;
}

/// As many digits behind the point as tell neighbours apart; large and tiny numbers by their power.
std::string labelOf(double value, double spacing) {
    if (std::abs(value) < 0.5 * spacing) return "0";
    const int digits = static_cast<int>(std::ceil(-std::log10(spacing) - 1e-9));
    if (std::abs(value) >= 1e5 || digits > 4)
        return fmt::format(
            "{:.{}g}", value,
            std::clamp(static_cast<int>(std::ceil(std::log10(std::abs(value) / spacing) + 1.0)), 1, 12));
    return fmt::format("{:.{}f}", value, std::max(digits, 0));
}

}  // namespace

PlotTicks ticksOf(const Interval& axis, std::string_view unit, int most) {
    PlotTicks ticks;
    const double extent = axis.high - axis.low;
    const double magnitude = std::max(std::abs(axis.low), std::abs(axis.high));
    const auto scaled = scaledUnit(magnitude, unit);
    ticks.unit = scaled.name;
    // Below a billionth of its place the numbers of an axis are no longer told apart.
    if (!std::isfinite(extent) || !(extent > 1e-9 * magnitude) || most < 1) return ticks;
    const double spacing = spacingOf(extent, most);
    if (!(spacing > 0.0) || !std::isfinite(spacing)) return ticks;
    const double first = std::ceil(axis.low / spacing - 1e-9);
    for (int i = 0; i <= most && (first + i) * spacing <= axis.high + 1e-9 * spacing; ++i) {
        const double value = (first + i) * spacing;
        ticks.at.push_back(std::clamp(value, axis.low, axis.high));
        ticks.labels.push_back(labelOf(value / scaled.scale, spacing / scaled.scale));
    }
    return ticks;
}

std::string axisTitle(std::string_view name, std::string_view unit) {
    if (unit.empty() || unit == "1") return std::string(name);
    return fmt::format("{} [{}]", name, unit);
}

}  // namespace mote::client
