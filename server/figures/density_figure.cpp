// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/figures/density_figure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "protocol/base/mote_check.h"
#include "protocol/scene/srgb.h"
#include "server/figures/figure_sheet.h"
#include "server/figures/plot_axis.h"
#include "server/figures/quantity_text.h"

namespace mote::server {
namespace {

constexpr double marginalShare = 0.17;  // of the frame and its marginal together
constexpr double fillOpacity = 0.25;

/// The counts along one axis, summed over the other.
std::vector<double> marginal(const HistogramFigure& figure, int axis) {
    const std::size_t columns = figure.axes[0].edges.size() - 1, rows = figure.axes[1].edges.size() - 1;
    std::vector<double> sums(axis == 0 ? columns : rows, 0.0);
    for (std::size_t i = 0; i < columns; ++i) {
        for (std::size_t j = 0; j < rows; ++j) {
            const double count = figure.counts[i * rows + j];
            if (std::isfinite(count)) sums[axis == 0 ? i : j] += count;
        }
    }
    return sums;
}

/// An axis without ticks, for the height of a marginal.
PlotAxis heightOf(Side side, const std::vector<double>& counts) {
    const auto most = std::max_element(counts.begin(), counts.end());
    const double high = most != counts.end() && *most > 0.0 ? *most : 1.0;
    return {side, {0.0, 1.05 * high}, {}, {}, false};
}

/// The curve around which a Gaussian beam of these moments has the density exp(-1/2) of its greatest, whose
/// area over pi is the rms emittance.
std::vector<glm::dvec2> ellipseOf(const RmsEllipse& ellipse, const PlotAxis& across, const PlotAxis& up,
                                  const Box& frame) {
    constexpr int corners = 180;
    const double sigma = std::sqrt(ellipse.xx);
    const double slope = ellipse.xy / sigma;  // of y, for a sigma of x
    const double rest = std::sqrt(std::max(0.0, ellipse.yy - slope * slope));
    std::vector<glm::dvec2> points;
    for (int i = 0; i < corners; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / corners;
        const double x = ellipse.meanX + sigma * std::cos(angle);
        const double y = ellipse.meanY + slope * std::cos(angle) + rest * std::sin(angle);
        points.emplace_back(across.place(x, frame), up.place(y, frame));
    }
    return points;
}

bool drawable(const RmsEllipse& ellipse) {
    return std::isfinite(ellipse.meanX) && std::isfinite(ellipse.meanY) && std::isfinite(ellipse.xy) &&
           ellipse.xx > 0.0 && ellipse.yy > 0.0 && std::isfinite(ellipse.xx) && std::isfinite(ellipse.yy);
}

/// What of a closed way lies in a box, as open ways.
std::vector<std::vector<glm::dvec2>> within(const Box& box, const std::vector<glm::dvec2>& points) {
    std::vector<std::vector<glm::dvec2>> parts(1);
    for (std::size_t i = 0; i <= points.size(); ++i) {
        const auto& at = points[i % points.size()];
        const auto& before = points[(i + points.size() - 1) % points.size()];
        const bool inside = box.holds({at, at}) && (i == 0 || box.holds({before, before}));
        if (!inside && !parts.back().empty()) parts.emplace_back();
        if (box.holds({at, at})) parts.back().push_back(at);
    }
    return parts;
}

void addEllipse(const RmsEllipse& ellipse, const PlotAxis& across, const PlotAxis& up, const Box& frame,
                const PlotLook& look, Marks& marks) {
    // With an edge of the paper's colour, it is seen on any colour of the map.
    for (const auto& part : within(frame, ellipseOf(ellipse, across, up, frame))) {
        if (part.size() < 2) continue;
        marks.push_back(LineMark{part, 3.2 * look.line, {look.paper, 0.8}});
        marks.push_back(LineMark{part, 1.6 * look.line, seriesInk(1, look)});
    }
}

/// Where the parts of the figure lie.
struct Places {
    Box frame, bar, above, beside;
};

/// From the sheet's area, the axes' rooms taken off.
Places placesIn(Box area, const FigureStyle& style, const PlotLook& look, double left, double below,
                double barRoom) {
    area.low.x += left;
    area.high.y -= below;
    Places places;
    const double barWidth = colorBarWidth * look.font;
    places.bar.high.x = area.high.x - barRoom;
    places.bar.low.x = places.bar.high.x - barWidth;
    area.high.x = places.bar.low.x - colorBarGap * look.font;
    places.frame = area;
    if (style.marginals) {
        const double gap = 0.35 * look.font;
        places.frame.low.y = area.low.y + marginalShare * area.size().y;
        places.frame.high.x = area.high.x - marginalShare * area.size().x;
        places.above = {area.low, {places.frame.high.x, places.frame.low.y - gap}};
        places.beside = {{places.frame.high.x + gap, places.frame.low.y}, area.high};
    }
    places.bar.low.y = places.frame.low.y;
    places.bar.high.y = places.frame.high.y;
    return places;
}

void addMarginals(const HistogramFigure& figure, const Places& places, const PlotAxis& across,
                  const PlotAxis& up, FigureSheet& sheet) {
    const auto byX = marginal(figure, 0), byY = marginal(figure, 1);
    addSteps(figure.axes[0].edges, byX, across, heightOf(Side::left, byX), places.above, sheet.look(),
             sheet.marks());
    addSteps(figure.axes[1].edges, byY, up, heightOf(Side::bottom, byY), places.beside, sheet.look(),
             sheet.marks());
}

}  // namespace

Ink seriesInk(std::size_t index, const PlotLook& look) {
    // Black, or white, comes last: axes have it.
    constexpr int bytes[][3] = {{0, 114, 178}, {213, 94, 0},   {0, 158, 115},  {204, 121, 167},
                                {230, 159, 0}, {86, 180, 233}, {120, 120, 120}};
    const bool dark = look.paper.x < 0.5;
    const auto& color = bytes[(dark && index == 0 ? 5 : index) % std::size(bytes)];
    return {glm::dvec3(color[0], color[1], color[2]) / 255.0};
}

AxisScale colorScale(const std::vector<double>& counts, bool logarithmic) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const double count : counts) {
        if (!std::isfinite(count) || count == 0.0 || (logarithmic && count < 0.0)) continue;
        low = std::min(low, count);
        high = std::max(high, count);
    }
    if (low > high) return logarithmic ? AxisScale{1.0, 10.0, true} : AxisScale{0.0, 1.0};
    if (logarithmic) return {low, high > low ? high : 10.0 * low, true};
    return {std::min(0.0, low), std::max(0.0, high)};
}

ImageMark cellImage(const Box& box, std::uint32_t columns, std::uint32_t rows, const AxisScale& scale,
                    const ColorMap& colorMap,
                    const std::function<double(std::uint32_t column, std::uint32_t row)>& countOf) {
    constexpr std::size_t shades = 1024;
    std::array<std::array<std::uint8_t, 3>, shades> table{};
    for (std::size_t i = 0; i < shades; ++i) {
        const auto color = linearToSrgb(colorMap(static_cast<double>(i) / (shades - 1)));
        for (int c = 0; c < 3; ++c)
            table[i][static_cast<std::size_t>(c)] = static_cast<std::uint8_t>(std::lround(255.0 * color[c]));
    }
    ImageMark image{box, columns, rows, std::vector<std::uint8_t>(std::size_t{4} * columns * rows, 0)};
    auto* pixel = image.rgba.data();
    for (std::uint32_t row = 0; row < rows; ++row) {
        for (std::uint32_t column = 0; column < columns; ++column, pixel += 4) {
            const double count = countOf(column, row);
            if (!std::isfinite(count) || count == 0.0 || (scale.logarithmic && !(count > 0.0))) continue;
            const double share = std::clamp(scale.share(count), 0.0, 1.0);
            const auto& color = table[static_cast<std::size_t>(std::lround(share * (shades - 1)))];
            std::copy(color.begin(), color.end(), pixel);
            pixel[3] = 255;
        }
    }
    return image;
}

void addSteps(const std::vector<double>& edges, const std::vector<double>& counts, const PlotAxis& values,
              const PlotAxis& height, const Box& frame, const PlotLook& look, Marks& marks) {
    const bool upright = height.side == Side::left || height.side == Side::right;
    const auto at = [&](double value, double count) {
        const double least = height.scale.low;
        if (!std::isfinite(count)) count = least;
        if (height.scale.logarithmic) count = std::max(count, least);
        const double along = values.place(value, frame), across = height.place(count, frame);
        return upright ? glm::dvec2(along, across) : glm::dvec2(across, along);
    };
    const double base = height.scale.logarithmic ? height.scale.low : std::max(0.0, height.scale.low);
    std::vector<glm::dvec2> steps{at(edges.front(), base)};
    for (std::size_t i = 0; i < counts.size(); ++i) {
        steps.push_back(at(edges[i], counts[i]));
        steps.push_back(at(edges[i + 1], counts[i]));
    }
    steps.push_back(at(edges.back(), base));
    Ink ink = seriesInk(0, look);
    marks.push_back(LineMark{steps, 1.4 * look.line, ink});
    ink.opacity = fillOpacity;
    marks.insert(marks.end() - 1, AreaMark{std::move(steps), ink});
}

Result<FigureDocument> drawDensity(const HistogramFigure& figure, const FigureStyle& style) {
    const auto &first = figure.axes[0], &second = figure.axes[1];
    const auto columns = static_cast<std::uint32_t>(first.edges.size() - 1);
    const auto rows = static_cast<std::uint32_t>(second.edges.size() - 1);
    MOTE_CHECK(first.edges.size() >= 2 && second.edges.size() >= 2);
    MOTE_CHECK(figure.counts.size() == std::size_t{columns} * rows);
    FigureSheet sheet(style);
    const auto& look = sheet.look();
    const auto& typeface = sheet.typeface();
    const AxisScale colors = colorScale(figure.counts, style.logScale);
    Box area = sheet.area();
    if (!style.marginals) area.low.y += 0.5 * look.font;
    const double height = area.size().y * (style.marginals ? 1.0 - marginalShare : 1.0) - 3.0 * look.font;
    MOTE_ASSIGN_OR_RETURN(const auto bar, makeAxis(Side::right, colors, countUnit(figure.unit),
                                                   countText(figure.unit), height, look, typeface));
    MOTE_ASSIGN_OR_RETURN(const auto left,
                          makeAxis(Side::left, {second.edges.front(), second.edges.back()}, second.unit,
                                   quantityText(second.quantity), height, look, typeface));
    const double leftRoom = roomOf(left, look, typeface), barRoom = roomOf(bar, look, typeface);
    const double width = placesIn(area, style, look, leftRoom, 0.0, barRoom).frame.size().x;
    MOTE_ASSIGN_OR_RETURN(const auto bottom,
                          makeAxis(Side::bottom, {first.edges.front(), first.edges.back()}, first.unit,
                                   quantityText(first.quantity), width, look, typeface));
    const Places places = placesIn(area, style, look, leftRoom, roomOf(bottom, look, typeface), barRoom);
    auto& marks = sheet.marks();
    marks.push_back(cellImage(
        places.frame, columns, rows, colors, style.colorMap,
        [&](auto column, auto row) { return figure.counts[std::size_t{column} * rows + (rows - 1 - row)]; }));
    if (style.marginals) addMarginals(figure, places, bottom, left, sheet);
    if (style.ellipse && figure.ellipse && drawable(*figure.ellipse))
        addEllipse(*figure.ellipse, bottom, left, places.frame, look, marks);
    addFrame(places.frame, look, marks);
    addAxis(bottom, places.frame, look, typeface, marks);
    addAxis(left, places.frame, look, typeface, marks);
    addColorBar(
        places.bar, bar, [&](double share) { return style.colorMap(share); }, look, typeface, marks);
    return sheet.document();
}

}  // namespace mote::server
