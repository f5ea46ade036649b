// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/numbers/plot_frame.h"

#include <algorithm>

#include "client/view/numbers/plot_ticks.h"

namespace mote::client {
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
    draw.AddRect(frame.from, frame.to, plotLine);
    const auto across = ticksAcross(frame, titles.xUnit);
    const float labelTop = frame.to.y + gap;
    for (std::size_t i = 0; i < across.at.size(); ++i) {
        const float x = frame.across(across.at[i]);
        const ImVec2 size = ImGui::CalcTextSize(across.labels[i].c_str());
        draw.AddLine({x, frame.to.y}, {x, frame.to.y - markLength}, plotLine);
        draw.AddText({x - 0.5F * size.x, labelTop}, plotText, across.labels[i].c_str());
    }
    const auto title = axisTitle(titles.x, across.unit);
    const ImVec2 size = ImGui::CalcTextSize(title.c_str());
    const float middle = 0.5F * (frame.from.x + frame.to.x);
    draw.AddText({middle - 0.5F * size.x, labelTop + ImGui::GetFontSize() + gap}, plotText, title.c_str());

    const auto up = ticksUp(frame, titles.yUnit);
    for (std::size_t i = 0; i < up.at.size(); ++i) {
        const float y = frame.down(up.at[i]);
        const ImVec2 label = ImGui::CalcTextSize(up.labels[i].c_str());
        draw.AddLine({frame.from.x, y}, {frame.from.x + markLength, y}, plotLine);
        draw.AddText({frame.from.x - label.x - gap, y - 0.5F * label.y}, plotText, up.labels[i].c_str());
    }
    const auto upTitle = axisTitle(titles.y, up.unit);
    draw.AddText({frame.from.x, frame.from.y - ImGui::GetFontSize() - gap}, plotText, upTitle.c_str());
}

}  // namespace mote::client
