// SPDX-License-Identifier: GPL-3.0-or-later
//
// PlotFrame: a rectangle of the screen with an axis along each side: where values lie in it, and its grid,
// marks and titles. Main thread, inside a Dear ImGui window.
#pragma once

#include <imgui.h>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "client/view/knot_curve.h"

namespace mote::client {

/// Where an axis of a plot has marks and what stands at them: round numbers in a prefix of the
/// axis' unit. Pure functions.
struct PlotTicks {
    std::vector<double> at;           ///< in the axis' unit, ascending
    std::vector<std::string> labels;  ///< as many, in the scaled unit
    std::string unit;                 ///< scaled: "mm"; empty: it has none
};

/// Returns at most `most` marks, 1, 2 or 5 times a power of ten apart; none on an axis that is not finite or
/// has no extent.
PlotTicks ticksOf(const Interval& axis, std::string_view unit, int most);

/// "x [mm]"; the name alone if there is no unit.
std::string axisTitle(std::string_view name, std::string_view unit);

struct PlotFrame {
    ImVec2 from, to;  ///< of the plot itself, upper left and lower right, pixels
    Interval x, y;

    float across(double value) const {
        return from.x + static_cast<float>((value - x.low) / (x.high - x.low)) * (to.x - from.x);
    }
    float down(double value) const {
        return to.y - static_cast<float>((value - y.low) / (y.high - y.low)) * (to.y - from.y);
    }
    ImVec2 at(double first, double second) const { return {across(first), down(second)}; }
    double firstAt(float pixel) const {
        return x.low + (x.high - x.low) * static_cast<double>((pixel - from.x) / (to.x - from.x));
    }
    double secondAt(float pixel) const {
        return y.low + (y.high - y.low) * static_cast<double>((to.y - pixel) / (to.y - from.y));
    }
    bool holds(const ImVec2& at) const {
        return at.x >= from.x && at.x < to.x && at.y >= from.y && at.y < to.y;
    }
};

/// What stands at the axes of a frame.
struct PlotTitles {
    std::string x, xUnit, y, yUnit;
};

inline constexpr ImU32 plotGround = IM_COL32(14, 16, 21, 255), plotLine = IM_COL32(255, 255, 255, 70);
inline constexpr ImU32 wholeColor = IM_COL32(140, 200, 255, 255);  ///< of what all particles give

/// Room that marks and titles take beside a plot, pixels: left, and below.
ImVec2 plotMargin();

/// The ground and the grid, before what the plot shows.
void drawGround(const PlotFrame& frame);
/// Marks, titles and the frame, after it.
void drawAxes(const PlotFrame& frame, const PlotTitles& titles);

/// A statistic over the steps as lines, of all particles and of a selection; a click goes to a
/// step. Main thread, inside a Dear ImGui window.
struct SeriesPlot {
    std::string name, unit;            ///< of the statistic
    std::span<const double> whole;     ///< by step; NaN leaves a gap
    std::span<const double> selected;  ///< likewise; it may be shorter
    std::array<float, 3> color{};      ///< of the selection's line, sRGB-encoded
    std::uint32_t step = 0;            ///< that is shown
    float height = 0.0F;               ///< pixels
};

/// What the finite values of both span, with a little room; 0 to 1 if there is none.
Interval extentOf(std::span<const double> first, std::span<const double> second);

/// Draws it over the width that is left; the step that the user goes to.
std::optional<std::uint32_t> drawSeries(const SeriesPlot& plot);

}  // namespace mote::client
