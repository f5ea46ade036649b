// SPDX-License-Identifier: GPL-3.0-or-later
//
// Histograms of one axis: a curve of steps over its bins.
#include <algorithm>
#include <cmath>
#include <limits>

#include "protocol/base/mote_check.h"
#include "server/figures/density_figure.h"
#include "server/figures/draw_figure.h"
#include "server/figures/figure_sheet.h"
#include "server/figures/quantity_text.h"

namespace mote::server {
namespace {

/// What the counts span; of logarithmic ones those above 0.
AxisScale countScale(const std::vector<double>& counts, bool logarithmic) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const double count : counts) {
        if (!std::isfinite(count) || (logarithmic && !(count > 0.0))) continue;
        low = std::min(low, count);
        high = std::max(high, count);
    }
    if (low > high) return logarithmic ? AxisScale{1.0, 10.0, true} : AxisScale{0.0, 1.0};
    if (logarithmic) return {low / 1.5, high * 1.5, true};
    low = std::min(low, 0.0);
    high = std::max(high, 0.0);
    if (low == high) return {0.0, 1.0};
    const double room = 0.05 * (high - low);
    return {low < 0.0 ? low - room : 0.0, high > 0.0 ? high + room : 0.0};
}

}  // namespace

Result<FigureDocument> drawHistogram(const HistogramFigure& figure, const FigureStyle& style) {
    MOTE_CHECK(!figure.axes.empty() && figure.axes.size() <= 2);
    if (figure.axes.size() == 2) return drawDensity(figure, style);
    const auto& edges = figure.axes[0].edges;
    MOTE_CHECK(edges.size() >= 2 && figure.counts.size() + 1 == edges.size());
    FigureSheet sheet(style);
    const auto& look = sheet.look();
    const AxisScale across{edges.front(), edges.back()};
    const AxisScale up = countScale(figure.counts, style.logScale);
    Box frame = sheet.area();
    frame.low.y += 0.5 * look.font;
    frame.high.x -= 0.8 * look.font;
    MOTE_ASSIGN_OR_RETURN(const auto left,
                          makeAxis(Side::left, up, countUnit(figure.unit), countText(figure.unit),
                                   frame.size().y - 3.0 * look.font, look, sheet.typeface()));
    frame.low.x += roomOf(left, look, sheet.typeface());
    MOTE_ASSIGN_OR_RETURN(const auto bottom, makeAxis(Side::bottom, across, figure.axes[0].unit,
                                                      quantityText(figure.axes[0].quantity), frame.size().x,
                                                      look, sheet.typeface()));
    frame.high.y -= roomOf(bottom, look, sheet.typeface());
    addSteps(edges, figure.counts, bottom, left, frame, look, sheet.marks());
    addFrame(frame, look, sheet.marks());
    addAxis(bottom, frame, look, sheet.typeface(), sheet.marks());
    addAxis(left, frame, look, sheet.typeface(), sheet.marks());
    return sheet.document();
}

}  // namespace mote::server
