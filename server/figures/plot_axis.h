// SPDX-License-Identifier: GPL-3.0-or-later
//
// An axis of a flat plot: where a value lies along a side of its frame, its ticks and its title. Values and
// pure functions that add marks; lengths in the unit of the marks.
#pragma once

#include <functional>
#include <string>

#include "server/figures/marks.h"
#include "server/figures/ticks.h"
#include "server/figures/typeface.h"

namespace mote::server {

/// How lines and letters of a drawing look.
struct PlotLook {
    double font = 8.0;      ///< an em of tick labels and titles
    double line = 0.5;      ///< the width of frames and ticks
    Ink ink;                ///< of lines and letters
    Ink halo = {{}, 0.0};   ///< around letters
    glm::dvec3 paper{1.0};  ///< what they stand on, sRGB-encoded

    double tick() const { return 0.35 * font; }
    double gap() const { return 0.3 * font; }  ///< between tick, label and title
};

enum class Side { bottom, left, top, right };

/// Where values lie between two ends, which differ and are finite; of a logarithmic axis above 0.
struct AxisScale {
    double low = 0.0, high = 1.0;
    bool logarithmic = false;

    /// 0 at the low end, 1 at the high one.
    double share(double value) const;
};

struct PlotAxis {
    Side side = Side::bottom;
    AxisScale scale;
    Ticks ticks;
    RichText title;
    bool labels = true;

    /// Where a value lies on the frame's side, across or down.
    double place(double value, const Box& frame) const;
};

/// An axis with as many ticks as have room along `length`. Ends that are equal are moved apart first. Errors:
/// as of linearTicks() and logTicks().
Result<PlotAxis> makeAxis(Side side, AxisScale scale, std::string_view unit, const RichText& name,
                          double length, const PlotLook& look, const Typeface& typeface);

/// How far labels and title reach outwards from the frame.
double roomOf(const PlotAxis& axis, const PlotLook& look, const Typeface& typeface);

void addAxis(const PlotAxis& axis, const Box& frame, const PlotLook& look, const Typeface& typeface,
             Marks& marks);
void addFrame(const Box& frame, const PlotLook& look, Marks& marks);

/// A text that is no wider, shortened by "…" if need be.
RichText shortened(RichText text, double size, double width, const Typeface& typeface);

/// Adds a colour bar: which colour stands for which value, upright, with an axis on its right. `color`:
/// linear RGB, by the share of the way from the low end to the high one.
void addColorBar(const Box& box, const PlotAxis& axis, const std::function<glm::dvec3(double)>& color,
                 const PlotLook& look, const Typeface& typeface, Marks& marks);

}  // namespace mote::server
