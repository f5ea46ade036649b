// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/numbers/series_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "client/view/numbers/plot_frame.h"
#include "client/view/numbers/statistic_rows.h"

namespace mote::client {
namespace {

constexpr float right = 6.0F;  // pixels free at the right edge

void drawLine(const PlotFrame& frame, std::span<const double> values, ImU32 color) {
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    for (std::size_t i = 0; i < values.size(); ++i) {
        const bool ends = i + 1 == values.size() || !std::isfinite(values[i + 1]);
        if (std::isfinite(values[i])) draw.PathLineTo(frame.at(static_cast<double>(i), values[i]));
        if (ends) draw.PathStroke(color, 0, 1.8F);
    }
    const float radius = values.size() > 60 ? 1.2F : 2.2F;
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (std::isfinite(values[i]))
            draw.AddCircleFilled(frame.at(static_cast<double>(i), values[i]), radius, color, 8);
    }
}

double valueAt(std::span<const double> values, std::uint32_t step) {
    return step < values.size() ? values[step] : std::numeric_limits<double>::quiet_NaN();
}

void tell(const SeriesPlot& plot, std::uint32_t step) {
    auto text =
        fmt::format("step {}\n{} {}", step, plot.name, numberText(valueAt(plot.whole, step), plot.unit));
    if (!plot.selected.empty())
        text += fmt::format("\nselection {}", numberText(valueAt(plot.selected, step), plot.unit));
    ImGui::SetTooltip("%s", text.c_str());
}

}  // namespace

Interval extentOf(std::span<const double> first, std::span<const double> second) {
    double low = std::numeric_limits<double>::max(), high = std::numeric_limits<double>::lowest();
    for (const auto values : {first, second}) {
        for (const double value : values) {
            if (!std::isfinite(value)) continue;
            low = std::min(low, value);
            high = std::max(high, value);
        }
    }
    if (low > high) return {};
    const double least = 1e-6 * std::max(std::abs(low), std::abs(high));
    const double room = std::max({0.06 * (high - low), least, std::numeric_limits<double>::min()});
    return {low - room, high + room};
}

std::optional<std::uint32_t> drawSeries(const SeriesPlot& plot) {
    const ImVec2 origin = ImGui::GetCursorScreenPos();
    const float width = ImGui::GetContentRegionAvail().x;
    ImGui::InvisibleButton("series", {width, plot.height});
    const auto steps = std::max(plot.whole.size(), plot.selected.size());
    if (steps < 2) return std::nullopt;
    const ImVec2 margin = plotMargin();
    const PlotFrame frame{{origin.x + margin.x, origin.y + 1.4F * ImGui::GetFontSize()},
                          {origin.x + width - right, origin.y + plot.height - margin.y},
                          {0.0, static_cast<double>(steps - 1)},
                          extentOf(plot.whole, plot.selected)};
    drawGround(frame);
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const float now = frame.across(plot.step);
    draw.AddLine({now, frame.from.y}, {now, frame.to.y}, IM_COL32(255, 176, 84, 200), 1.5F);
    drawLine(frame, plot.whole, wholeColor);
    drawLine(frame, plot.selected,
             ImGui::ColorConvertFloat4ToU32({plot.color[0], plot.color[1], plot.color[2], 1.0F}));
    drawAxes(frame, {"step", "", plot.name, plot.unit});
    const double share = frame.firstAt(ImGui::GetIO().MousePos.x);
    const auto under =
        static_cast<std::uint32_t>(std::lround(std::clamp(share, 0.0, static_cast<double>(steps - 1))));
    if (ImGui::IsItemHovered()) tell(plot, under);
    if (ImGui::IsItemActive() && under != plot.step) return under;
    return std::nullopt;
}

}  // namespace mote::client
