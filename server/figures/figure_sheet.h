// SPDX-License-Identifier: GPL-3.0-or-later
//
// FigureSheet: the sheet that a figure is drawn on, in points of type, with its look, its typeface and its
// title; and the document that it becomes. One owner, one thread.
#pragma once

#include <string>
#include <vector>

#include "server/figures/draw_figure.h"
#include "server/figures/marks.h"
#include "server/figures/plot_axis.h"
#include "server/figures/typeface.h"

namespace mote::server {

class FigureSheet {
  public:
    explicit FigureSheet(const FigureStyle& style);

    const FigureStyle& style() const { return style_; }
    const PlotLook& look() const { return look_; }
    const Typeface& typeface() const { return typeface_; }
    Marks& marks() { return marks_; }
    /// What the title leaves, within a margin.
    const Box& area() const { return area_; }

    Result<FigureDocument> document() const;

  private:
    Result<FigureDocument> png() const;
    Result<FigureDocument> svg() const;
    Result<FigureDocument> pdf() const;

    const FigureStyle style_;
    const glm::dvec2 size_;  // points
    PlotLook look_;
    Typeface typeface_;
    Box area_;
    Marks marks_;
};

/// "particles per bin", "charge per bin" and their unit.
RichText countText(const CountUnit& unit);
std::string countUnit(const CountUnit& unit);

/// Where steps lie along an axis: their times, or, if these do not ascend, their numbers.
struct StepPlaces {
    std::vector<double> places;
    RichText name;
    std::string unit;
};
StepPlaces placesOf(const std::vector<double>& times);

}  // namespace mote::server
