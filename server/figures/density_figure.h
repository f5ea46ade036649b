// SPDX-License-Identifier: GPL-3.0-or-later
//
// Parts of figures of counts: densities as images with their marginals and ellipse, and curves of steps. Pure
// functions that add marks; of draw_figure.h alone.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "server/figures/draw_figure.h"
#include "server/figures/marks.h"
#include "server/figures/plot_axis.h"

namespace mote::server {

/// A histogram of two axes.
Result<FigureDocument> drawDensity(const HistogramFigure& figure, const FigureStyle& style);

/// The counts of a histogram as a curve of steps with what lies beneath it filled. `values`: the axis of the
/// edges; `counts`: that of the counts, across it.
void addSteps(const std::vector<double>& edges, const std::vector<double>& counts, const PlotAxis& values,
              const PlotAxis& height, const Box& frame, const PlotLook& look, Marks& marks);

/// What colours stand for: the span of the counts that are shown.
AxisScale colorScale(const std::vector<double>& counts, bool logarithmic);

/// Counts as an image of cells, row 0 on top. Empty cells, and such that are not finite, are not drawn.
ImageMark cellImage(const Box& box, std::uint32_t columns, std::uint32_t rows, const AxisScale& scale,
                    const ColorMap& colorMap,
                    const std::function<double(std::uint32_t column, std::uint32_t row)>& countOf);

/// The width of a colour bar, and its distance from what it is of.
constexpr double colorBarWidth = 0.9;  ///< em
constexpr double colorBarGap = 0.8;    ///< em

/// The colour of lines that show numbers; the next ones differ from it for every eye (Okabe and Ito 2008).
Ink seriesInk(std::size_t index, const PlotLook& look);

}  // namespace mote::server
