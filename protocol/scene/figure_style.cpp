// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/figure_style.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "protocol/base/check.h"
#include "protocol/scene/annotations.h"
#include "protocol/scene/length_scale.h"
#include "protocol/scene/view.h"

namespace mote {
namespace {

constexpr double leastLetters = 10.0;  // of the font's size, across and down a figure
constexpr std::string_view ofTwoAxes = "is of a histogram of two axes";

std::uint32_t pixelsOf(double length, double dotsPerInch) {
    return std::max(1U, static_cast<std::uint32_t>(std::lround(length / inchInMillimeters * dotsPerInch)));
}

Status checkWhat(const proto::FigureQuery& message) {
    const bool histogram = message.has_histogram();
    const int axes = message.histogram().axes_size(), statistics = message.statistics_size();
    if (histogram == (statistics > 0))
        return invalid("histogram", "a figure is of a histogram or of statistics");
    if (histogram && (axes < 1 || axes > 2))
        return invalid("histogram.axes", fmt::format("1 or 2 are needed, not {}", axes));
    if (statistics > FigureStyle::mostStatistics)
        return invalid("statistics", fmt::format("at most {} are drawn", FigureStyle::mostStatistics));
    if (message.log_scale() && !histogram) return invalid("logScale", "is of the counts of a histogram");
    if (message.marginals() && axes != 2) return invalid("marginals", std::string(ofTwoAxes));
    if (message.ellipse() && axes != 2) return invalid("ellipse", std::string(ofTwoAxes));
    return success();
}

/// Of one line, without control characters: the same as above a picture.
Status checkFigureTitle(const std::string& title) {
    proto::Annotations annotations;
    annotations.set_title(title);
    return checkAnnotations(annotations);
}

}  // namespace

std::uint32_t FigureStyle::pixelWidth() const {
    return pixelsOf(width, dotsPerInch);
}
std::uint32_t FigureStyle::pixelHeight() const {
    return pixelsOf(height, dotsPerInch);
}

Result<FigureStyle> parseFigureStyle(const proto::FigureQuery& message) {
    FigureStyle style;
    style.format = message.format();
    if (style.format != proto::FigureQuery::PNG && style.format != proto::FigureQuery::SVG &&
        style.format != proto::FigureQuery::PDF)
        return invalid("format", "PNG, SVG or PDF is needed");
    MOTE_RETURN_IF_ERROR(checkWhat(message));
    constexpr double least = 10.0, most = 2000.0;  // mm
    const double width = message.has_width() ? message.width() : style.width;
    MOTE_ASSIGN_OR_RETURN(style.width, checkRange(width, least, most, "width"));
    const double height = message.has_height() ? message.height() : std::max(least, 0.75 * style.width);
    MOTE_ASSIGN_OR_RETURN(style.height, checkRange(height, least, most, "height"));
    const double font = message.has_font_points() ? message.font_points() : style.fontPoints;
    MOTE_ASSIGN_OR_RETURN(style.fontPoints, checkRange(font, 1.0, 200.0, "fontPoints"));
    const double side = std::min(style.width, style.height) / inchInMillimeters * inchInPoints;
    if (!message.has_font_points()) style.fontPoints = std::min(font, side / leastLetters);
    if (style.fontPoints * leastLetters > side * (1.0 + 1e-9))
        return invalid("fontPoints", "is more than a tenth of the figure's shorter side");
    const double dots = message.has_dots_per_inch() ? message.dots_per_inch() : style.dotsPerInch;
    MOTE_ASSIGN_OR_RETURN(style.dotsPerInch, checkRange(dots, 10.0, 4800.0, "dotsPerInch"));
    if (style.format == proto::FigureQuery::PNG &&
        std::uint64_t{style.pixelWidth()} * style.pixelHeight() > View::maxPixels)
        return invalid("dotsPerInch", fmt::format("the figure would have {} x {} pixels, more than {}",
                                                  style.pixelWidth(), style.pixelHeight(), View::maxPixels));
    style.dark = message.dark();
    style.logScale = message.log_scale();
    style.marginals = message.marginals();
    style.ellipse = message.ellipse();
    const auto map = ColorMap::find(message.color_map().empty() ? "viridis" : message.color_map());
    if (!map.ok()) return invalid("colorMap", map.error().message);
    style.colorMap = *map;
    MOTE_RETURN_IF_ERROR(checkFigureTitle(message.title()));
    style.title = message.title();
    return style;
}

}  // namespace mote
