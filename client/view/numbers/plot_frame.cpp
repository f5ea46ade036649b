// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/numbers/plot_frame.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>

#include "client/shared/numbers.h"
#include "client/view/numbers/quantities.h"

namespace mote::client {
namespace {

/// The least round distance of which at most `most` fit into `extent`.
double spacingOf(double extent, int most) {
    const double least = extent / most;
    const double power = std::pow(10.0, std::floor(std::log10(least)));
    for (const double factor : {1.0, 2.0, 5.0}) {
        if (factor * power >= least) return factor * power;
    }
    return 10.0 * power;
}

/// As many digits behind the point as tell neighbours apart; large and tiny numbers by their power.
std::string labelOf(double value, double spacing) {
    if (std::abs(value) < 0.5 * spacing) return "0";
    const int digits = static_cast<int>(std::ceil(-std::log10(spacing) - 1e-9));
    if (std::abs(value) >= 1e5 || digits > 4)
        return fmt::format(
            "{:.{}g}", value,
            std::clamp(static_cast<int>(std::ceil(std::log10(std::abs(value) / spacing) + 1.0)), 1, 12));
    return fmt::format("{:.{}f}", value, std::max(digits, 0));
}

}  // namespace

PlotTicks ticksOf(const Interval& axis, std::string_view unit, int most) {
    PlotTicks ticks;
    const double extent = axis.high - axis.low;
    const double magnitude = std::max(std::abs(axis.low), std::abs(axis.high));
    const auto scaled = scaledUnit(magnitude, unit);
    ticks.unit = scaled.name;
    // Below a billionth of its place the numbers of an axis are no longer told apart.
    if (!std::isfinite(extent) || !(extent > 1e-9 * magnitude) || most < 1) return ticks;
    const double spacing = spacingOf(extent, most);
    if (!(spacing > 0.0) || !std::isfinite(spacing)) return ticks;
    const double first = std::ceil(axis.low / spacing - 1e-9);
    for (int i = 0; i <= most && (first + i) * spacing <= axis.high + 1e-9 * spacing; ++i) {
        const double value = (first + i) * spacing;
        ticks.at.push_back(std::clamp(value, axis.low, axis.high));
        ticks.labels.push_back(labelOf(value / scaled.scale, spacing / scaled.scale));
    }
    return ticks;
}

std::string axisTitle(std::string_view name, std::string_view unit) {
    if (unit.empty() || unit == "1") return std::string(name);
    return fmt::format("{} [{}]", name, unit);
}

namespace {

constexpr ImU32 gridColor = IM_COL32(255, 255, 255, 20);
constexpr float markLength = 4.0F, gap = 3.0F;  // pixels

int mostTicks(float pixels, float each) {
    return std::clamp(static_cast<int>(pixels / (each * ImGui::GetFontSize())), 1, 12);
}

PlotTicks ticksAcross(const PlotFrame& frame, std::string_view unit) {
    return ticksOf(frame.x, unit, mostTicks(frame.to.x - frame.from.x, 4.0F));
}

PlotTicks ticksUp(const PlotFrame& frame, std::string_view unit) {
    return ticksOf(frame.y, unit, mostTicks(frame.to.y - frame.from.y, 2.2F));
}

}  // namespace

ImVec2 plotMargin() {
    const float letter = ImGui::GetFontSize();
    return {4.0F * letter, 2.0F * letter + 3.0F * gap};
}

void drawGround(const PlotFrame& frame) {
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    draw.AddRectFilled(frame.from, frame.to, plotGround);
    for (const double value : ticksAcross(frame, "").at) {
        const float x = frame.across(value);
        draw.AddLine({x, frame.from.y}, {x, frame.to.y}, gridColor);
    }
    for (const double value : ticksUp(frame, "").at) {
        const float y = frame.down(value);
        draw.AddLine({frame.from.x, y}, {frame.to.x, y}, gridColor);
    }
}

void drawAxes(const PlotFrame& frame, const PlotTitles& titles) {
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const ImU32 letters = ImGui::GetColorU32(ImGuiCol_Text, 0.85F);
    draw.AddRect(frame.from, frame.to, plotLine);
    const auto across = ticksAcross(frame, titles.xUnit);
    const float labelTop = frame.to.y + gap;
    for (std::size_t i = 0; i < across.at.size(); ++i) {
        const float x = frame.across(across.at[i]);
        const ImVec2 size = ImGui::CalcTextSize(across.labels[i].c_str());
        draw.AddLine({x, frame.to.y}, {x, frame.to.y - markLength}, plotLine);
        draw.AddText({x - 0.5F * size.x, labelTop}, letters, across.labels[i].c_str());
    }
    const auto title = axisTitle(titles.x, across.unit);
    const ImVec2 size = ImGui::CalcTextSize(title.c_str());
    const float middle = 0.5F * (frame.from.x + frame.to.x);
    draw.AddText({middle - 0.5F * size.x, labelTop + ImGui::GetFontSize() + gap}, letters, title.c_str());

    const auto up = ticksUp(frame, titles.yUnit);
    for (std::size_t i = 0; i < up.at.size(); ++i) {
        const float y = frame.down(up.at[i]);
        const ImVec2 label = ImGui::CalcTextSize(up.labels[i].c_str());
        draw.AddLine({frame.from.x, y}, {frame.from.x + markLength, y}, plotLine);
        draw.AddText({frame.from.x - label.x - gap, y - 0.5F * label.y}, letters, up.labels[i].c_str());
    }
    const auto upTitle = axisTitle(titles.y, up.unit);
    draw.AddText({frame.from.x, frame.from.y - ImGui::GetFontSize() - gap}, letters, upTitle.c_str());
}

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
