// SPDX-License-Identifier: GPL-3.0-or-later
//
// PlotFrame: a rectangle of the screen with an axis along each side: where values lie in it, and its grid,
// marks and titles. Main thread, inside a Dear ImGui window.
#pragma once

#include <imgui.h>

#include <string>

#include "client/view/knot_curve.h"

namespace mote::client {

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
inline constexpr ImU32 plotText = IM_COL32(225, 230, 240, 200);
inline constexpr ImU32 wholeColor = IM_COL32(140, 200, 255, 255);  ///< of what all particles give

/// Room that marks and titles take beside a plot, pixels: left, and below.
ImVec2 plotMargin();

/// The ground and the grid, before what the plot shows.
void drawGround(const PlotFrame& frame);
/// Marks, titles and the frame, after it.
void drawAxes(const PlotFrame& frame, const PlotTitles& titles);

}  // namespace mote::client
