// SPDX-License-Identifier: GPL-3.0-or-later
//
// Statistics over the steps of a run: a panel for each unit, one above another, over one axis of time.
#include <fmt/format.h>

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

constexpr double leastPanel = 5.0;  // em

struct Panel {
    std::string_view family;  ///< how the names of its series begin
    std::string unit;
    std::vector<std::size_t> series;
};

/// What statistics are of, by the beginning of their names: "norm_emit", "sigma", "mean", ...
std::string_view familyOf(std::string_view name) {
    for (const std::string_view family : {"norm_emit", "emit_", "twiss_alpha", "twiss_beta", "twiss_gamma"}) {
        if (name.substr(0, family.size()) == family) return family;
    }
    // "emit90_action_x" and the like are normalised.
    if (name.substr(0, 4) == "emit" && name.find("_action_") != std::string_view::npos) return "norm_emit";
    return name.substr(0, name.find('_'));
}

std::vector<Panel> panelsOf(const StatisticsFigure& figure) {
    std::vector<Panel> panels;
    for (std::size_t i = 0; i < figure.series.size(); ++i) {
        const Panel panel{familyOf(figure.series[i].name), figure.series[i].unit, {}};
        auto found = std::find_if(panels.begin(), panels.end(), [&](const Panel& other) {
            return other.family == panel.family && other.unit == panel.unit;
        });
        if (found == panels.end()) found = panels.insert(panels.end(), panel);
        found->series.push_back(i);
    }
    return panels;
}

/// What the values of a panel span, with room above and below; from 0 if that is not far.
AxisScale valueScale(const StatisticsFigure& figure, const Panel& panel) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const auto index : panel.series) {
        for (const double value : figure.series[index].values) {
            if (!std::isfinite(value) || std::abs(value) > 1e300) continue;
            low = std::min(low, value);
            high = std::max(high, value);
        }
    }
    if (low > high) return {0.0, 1.0};
    if (low > 0.0 && low < 0.5 * high) low = 0.0;
    if (high < 0.0 && high > 0.5 * low) high = 0.0;
    const double room = low < high ? 0.06 * (high - low) : 0.1 * std::abs(low);
    if (room == 0.0) return {low - 1.0, high + 1.0};
    return {low == 0.0 ? 0.0 : low - room, high == 0.0 ? 0.0 : high + room};
}

/// A curve with a gap where there is no number; a number alone between gaps is a dot.
void addCurve(const std::vector<double>& places, const std::vector<double>& values, const PlotAxis& across,
              const PlotAxis& up, const Box& frame, const Ink& ink, const PlotLook& look, Marks& marks) {
    std::vector<glm::dvec2> curve;
    const double width = 1.8 * look.line;
    const auto finish = [&] {
        if (curve.size() == 1) curve = {curve[0] - glm::dvec2(width, 0.0), curve[0] + glm::dvec2(width, 0.0)};
        if (!curve.empty()) marks.push_back(LineMark{std::exchange(curve, {}), width, ink});
    };
    for (std::size_t i = 0; i < values.size() && i < places.size(); ++i) {
        if (!std::isfinite(values[i]) || std::abs(values[i]) > 1e300) {
            finish();
            continue;
        }
        curve.emplace_back(across.place(places[i], frame), up.place(values[i], frame));
    }
    finish();
}

/// The names of a panel's series in a row above it, each behind a piece of its line. If one has a panel to
/// itself, the axis names it.
void addNames(const StatisticsFigure& figure, const Panel& panel, const Box& frame, FigureSheet& sheet) {
    const auto& look = sheet.look();
    double x = frame.low.x;
    const double y = frame.low.y - 0.45 * look.font, middle = y - 0.36 * look.font, line = 1.4 * look.font;
    for (std::size_t i = 0; i < panel.series.size(); ++i) {
        const auto name = statisticText(figure.series[panel.series[i]].name);
        const double width = sheet.typeface().layOut(name, look.font).width;
        if (x + line + width > frame.high.x && i > 0) return;  // the rest has no room
        sheet.marks().push_back(
            LineMark{{{x, middle}, {x + line, middle}}, 1.8 * look.line, seriesInk(i, look)});
        x += line + 0.4 * look.font;
        sheet.marks().push_back(TextMark{name, {x, y}, look.font, {0.0, 1.0}, 0.0, look.ink});
        x += width + look.font;
    }
}

/// What the axis of a panel says beside its unit.
RichText titleOf(const StatisticsFigure& figure, const Panel& panel) {
    if (panel.series.size() == 1) return statisticText(figure.series[panel.series[0]].name);
    if (panel.family == "norm_emit") return upright("normalised emittance");
    if (panel.family == "emit_") return upright("emittance");
    if (panel.family == "sigma") return upright("rms");
    if (panel.family == "mean") return upright("mean");
    return {};
}

}  // namespace

Result<FigureDocument> drawStatistics(const StatisticsFigure& figure, const FigureStyle& style) {
    MOTE_CHECK(!figure.series.empty() && !figure.times.empty());
    FigureSheet sheet(style);
    const auto& look = sheet.look();
    const auto& typeface = sheet.typeface();
    const auto steps = placesOf(figure.times);
    const auto panels = panelsOf(figure);
    const double gap = 0.9 * look.font;
    Box area = sheet.area();
    area.high.x -= 1.2 * look.font;
    constexpr double bottomRoom = 3.6;  // em
    const double each = (area.size().y - bottomRoom * look.font) / static_cast<double>(panels.size());
    if (each < leastPanel * look.font) {
        return Error{ErrorCode::invalidArgument, "height",
                     fmt::format("{} statistics of different kinds need more of it", panels.size())};
    }
    std::vector<PlotAxis> left;
    double leftRoom = 0.0;
    for (const auto& panel : panels) {
        const double names = panel.series.size() > 1 ? 1.5 * look.font : 0.0;
        MOTE_ASSIGN_OR_RETURN(
            auto axis, makeAxis(Side::left, valueScale(figure, panel), panel.unit, titleOf(figure, panel),
                                each - names - gap, look, typeface));
        leftRoom = std::max(leftRoom, roomOf(axis, look, typeface));
        left.push_back(std::move(axis));
    }
    area.low.x += leftRoom;
    MOTE_ASSIGN_OR_RETURN(auto bottom, makeAxis(Side::bottom, {steps.places.front(), steps.places.back()},
                                                steps.unit, steps.name, area.size().x, look, typeface));
    const double under = roomOf(bottom, look, typeface);
    const double height = (area.size().y - under) / static_cast<double>(panels.size());
    for (std::size_t i = 0; i < panels.size(); ++i) {
        const double names = panels[i].series.size() > 1 ? 1.5 * look.font : 0.0;
        Box frame = area;
        frame.low.y =
            area.low.y + height * static_cast<double>(i) + names + (i == 0 ? 0.4 * look.font : 0.5 * gap);
        frame.high.y =
            area.low.y + height * static_cast<double>(i + 1) - (i + 1 < panels.size() ? 0.5 * gap : 0.0);
        for (std::size_t k = 0; k < panels[i].series.size(); ++k) {
            addCurve(steps.places, figure.series[panels[i].series[k]].values, bottom, left[i], frame,
                     seriesInk(k, look), look, sheet.marks());
        }
        addFrame(frame, look, sheet.marks());
        PlotAxis across = bottom;
        across.labels = i + 1 == panels.size();
        if (!across.labels) across.title.clear();
        addAxis(across, frame, look, typeface, sheet.marks());
        addAxis(left[i], frame, look, typeface, sheet.marks());
        if (panels[i].series.size() > 1) addNames(figure, panels[i], frame, sheet);
    }
    return sheet.document();
}

}  // namespace mote::server
