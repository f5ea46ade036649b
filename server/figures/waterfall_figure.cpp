// SPDX-License-Identifier: GPL-3.0-or-later
//
// Waterfalls: a histogram of one axis over all steps, as an image whose columns are the steps.
#include <algorithm>

#include "protocol/base/mote_check.h"
#include "server/figures/density_figure.h"
#include "server/figures/draw_figure.h"
#include "server/figures/figure_sheet.h"
#include "server/figures/plot_axis.h"
#include "server/figures/quantity_text.h"

namespace mote::server {
namespace {

constexpr std::size_t mostColumns = 4096;  // of the image, if steps lie unevenly

/// The ends of the axis of steps: half a step beyond the first and the last.
AxisScale stepScale(const std::vector<double>& places) {
    const std::size_t count = places.size();
    if (count < 2) return {places.front() - 0.5, places.front() + 0.5};
    return {places[0] - 0.5 * (places[1] - places[0]),
            places[count - 1] + 0.5 * (places[count - 1] - places[count - 2])};
}

/// Which step lies nearest to each column of an image; as few columns as tell the steps apart.
std::vector<std::size_t> stepsOfColumns(const std::vector<double>& places, const AxisScale& scale) {
    double least = scale.high - scale.low, most = 0.0;
    for (std::size_t i = 1; i < places.size(); ++i) {
        least = std::min(least, places[i] - places[i - 1]);
        most = std::max(most, places[i] - places[i - 1]);
    }
    const bool even = most <= least * (1.0 + 1e-6);
    const std::size_t columns =
        even ? places.size() : std::max(mostColumns, std::min(places.size(), 4 * mostColumns));
    std::vector<std::size_t> steps(columns);
    std::size_t step = 0;
    for (std::size_t i = 0; i < columns; ++i) {
        if (even) {
            steps[i] = i;
            continue;
        }
        const double at = scale.low + (static_cast<double>(i) + 0.5) / static_cast<double>(columns) *
                                          (scale.high - scale.low);
        while (step + 1 < places.size() && at - places[step] > places[step + 1] - at) ++step;
        steps[i] = step;
    }
    return steps;
}

}  // namespace

Result<FigureDocument> drawWaterfall(const WaterfallFigure& figure, const FigureStyle& style) {
    const auto& edges = figure.axis.edges;
    MOTE_CHECK(edges.size() >= 2 && !figure.times.empty());
    const std::size_t bins = edges.size() - 1;
    MOTE_CHECK(figure.counts.size() == bins * figure.times.size());
    FigureSheet sheet(style);
    const auto& look = sheet.look();
    const auto& typeface = sheet.typeface();
    const auto steps = placesOf(figure.times);
    const AxisScale along = stepScale(steps.places), colors = colorScale(figure.counts, style.logScale);
    Box frame = sheet.area();
    frame.low.y += 0.5 * look.font;
    const double height = frame.size().y - 3.0 * look.font;
    MOTE_ASSIGN_OR_RETURN(const auto bar, makeAxis(Side::right, colors, countUnit(figure.unit),
                                                   countText(figure.unit), height, look, typeface));
    MOTE_ASSIGN_OR_RETURN(const auto left,
                          makeAxis(Side::left, {edges.front(), edges.back()}, figure.axis.unit,
                                   quantityText(figure.axis.quantity), height, look, typeface));
    Box barBox = frame;
    barBox.high.x -= roomOf(bar, look, typeface);
    barBox.low.x = barBox.high.x - colorBarWidth * look.font;
    frame.high.x = barBox.low.x - colorBarGap * look.font;
    frame.low.x += roomOf(left, look, typeface);
    MOTE_ASSIGN_OR_RETURN(const auto bottom, makeAxis(Side::bottom, along, steps.unit, steps.name,
                                                      frame.size().x, look, typeface));
    frame.high.y -= roomOf(bottom, look, typeface);
    barBox.low.y = frame.low.y;
    barBox.high.y = frame.high.y;
    const auto stepOf = stepsOfColumns(steps.places, along);
    auto& marks = sheet.marks();
    marks.push_back(cellImage(
        frame, static_cast<std::uint32_t>(stepOf.size()), static_cast<std::uint32_t>(bins), colors,
        style.colorMap,
        [&](auto column, auto row) { return figure.counts[stepOf[column] * bins + (bins - 1 - row)]; }));
    addFrame(frame, look, marks);
    addAxis(bottom, frame, look, typeface, marks);
    addAxis(left, frame, look, typeface, marks);
    addColorBar(
        barBox, bar, [&](double share) { return style.colorMap(share); }, look, typeface, marks);
    return sheet.document();
}

}  // namespace mote::server
