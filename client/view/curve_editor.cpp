// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/curve_editor.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "protocol/scene/srgb.h"

namespace mote::client {
namespace {

constexpr float knotRadius = 5.0F, grabRadius = 9.0F, stripHeight = 8.0F;  // pixels

/// Places curve coordinates on the screen. Opacities are small where they matter: their axis is a square
/// root.
struct Plot {
    ImVec2 origin;  // upper left
    ImVec2 size;
    Interval axis;
    bool rootAxis;

    float up(double y) const { return static_cast<float>(rootAxis ? std::sqrt(y) : y); }
    float across(double x) const {
        return origin.x + static_cast<float>((x - axis.low) / (axis.high - axis.low)) * size.x;
    }
    ImVec2 at(const Curve::Knot& knot) const {
        return {across(knot.x), origin.y + (1.0F - up(knot.y)) * size.y};
    }
    Curve::Knot from(const ImVec2& screen) const {
        const double x = std::clamp((screen.x - origin.x) / size.x, 0.0F, 1.0F);
        const double y = std::clamp(1.0F - (screen.y - origin.y) / size.y, 0.0F, 1.0F);
        return {axis.low + x * (axis.high - axis.low), rootAxis ? y * y : y};
    }
};

void drawHistogram(ImDrawList& draw, const Plot& plot, std::span<const std::uint64_t> bins,
                   const Interval& range) {
    const std::uint64_t most = bins.empty() ? 0 : *std::max_element(bins.begin(), bins.end());
    if (most == 0) return;
    const float begin = plot.across(range.low);
    const float width = (plot.across(range.high) - begin) / static_cast<float>(bins.size());
    const float scale = plot.size.y / std::log1p(static_cast<float>(most));
    for (std::size_t i = 0; i < bins.size(); ++i) {
        const float left = begin + width * static_cast<float>(i);
        const float bottom = plot.origin.y + plot.size.y;
        const float top = bottom - scale * std::log1p(static_cast<float>(bins[i]));
        draw.AddRectFilled({left, top}, {left + width, bottom}, IM_COL32(92, 104, 122, 150));
    }
}

void drawGrid(ImDrawList& draw, const Plot& plot) {
    const auto line = [&](double y, const char* label) {
        const float height = plot.at({plot.axis.low, y}).y;
        draw.AddLine({plot.origin.x, height}, {plot.origin.x + plot.size.x, height},
                     IM_COL32(255, 255, 255, 22));
        draw.AddText({plot.origin.x + 3.0F, height}, IM_COL32(255, 255, 255, 90), label);
    };
    if (plot.rootAxis) {
        line(0.01, "0.01");
        line(0.1, "0.1");
        line(0.4, "0.4");
    } else {
        line(0.25, "1/4");
        line(0.5, "1/2");
        line(0.75, "3/4");
    }
}

/// Level beyond the ends; straight pieces are bent by the square-root axis.
void drawCurve(ImDrawList& draw, const Plot& plot, const std::vector<Curve::Knot>& knots, ImU32 color) {
    draw.PathLineTo(plot.at({plot.axis.low, knots.front().y}));
    for (std::size_t i = 0; i < knots.size(); ++i) {
        constexpr int pieces = 24;
        const auto& from = knots[i > 0 ? i - 1 : 0];
        for (int piece = 1; piece <= pieces; ++piece) {
            const double share = static_cast<double>(piece) / pieces;
            draw.PathLineTo(
                plot.at({std::lerp(from.x, knots[i].x, share), std::lerp(from.y, knots[i].y, share)}));
        }
    }
    draw.PathLineTo(plot.at({plot.axis.high, knots.back().y}));
    draw.PathStroke(color, 0, 2.0F);
}

void drawStrip(ImDrawList& draw, const Plot& plot, const std::function<glm::dvec3(double)>& color) {
    constexpr int pieces = 128;
    const float top = plot.origin.y + plot.size.y;
    for (int i = 0; i < pieces; ++i) {
        const double x = std::lerp(plot.axis.low, plot.axis.high, (i + 0.5) / pieces);
        const auto shown = linearToSrgb(color(x)) * 255.0;
        const float left = plot.origin.x + plot.size.x * static_cast<float>(i) / pieces;
        draw.AddRectFilled(
            {left, top}, {left + plot.size.x / pieces + 1.0F, top + stripHeight},
            IM_COL32(static_cast<int>(shown.x), static_cast<int>(shown.y), static_cast<int>(shown.z), 255));
    }
}

std::optional<std::size_t> knotAt(const Plot& plot, const std::vector<Curve::Knot>& knots,
                                  const ImVec2& mouse) {
    std::optional<std::size_t> best;
    float nearest = grabRadius * grabRadius;
    for (std::size_t i = 0; i < knots.size(); ++i) {
        const ImVec2 at = plot.at(knots[i]);
        const float distance = (at.x - mouse.x) * (at.x - mouse.x) + (at.y - mouse.y) * (at.y - mouse.y);
        if (distance > nearest) continue;
        nearest = distance;
        best = i;
    }
    return best;
}

/// The knot that the mouse holds lives in Dear ImGui's own storage, one number a widget.
bool edit(const Plot& plot, EditedCurve& curve) {
    ImGuiStorage& storage = *ImGui::GetStateStorage();
    const ImGuiID held = ImGui::GetID("held");
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    const auto under = ImGui::IsItemHovered() ? knotAt(plot, curve.knots(), mouse) : std::nullopt;
    if (under && ImGui::IsMouseClicked(ImGuiMouseButton_Right)) {
        curve.remove(*under);
        return true;
    }
    if (ImGui::IsItemActivated()) {
        const auto grabbed = under ? *under : curve.insert(plot.from(mouse));
        storage.SetInt(held, static_cast<int>(grabbed));
        curve.choose(grabbed);
        return !under;
    }
    const auto& drag = ImGui::GetIO().MouseDelta;
    if (!ImGui::IsItemActive() || (drag.x == 0.0F && drag.y == 0.0F)) return false;
    const auto knot = static_cast<std::size_t>(storage.GetInt(held));
    if (knot >= curve.knots().size()) return false;
    curve.move(knot, plot.from(mouse));
    return true;
}

}  // namespace

bool curveEditor(const char* id, EditedCurve& curve, const CurveEditorLook& look) {
    ImGui::PushID(id);
    const float width = ImGui::GetContentRegionAvail().x;
    const Plot plot{ImGui::GetCursorScreenPos(), {width, look.height}, look.axis, look.rootAxis};
    ImGui::InvisibleButton("plot", {width, look.height});
    const bool changed = edit(plot, curve);
    if (ImGui::IsItemHovered()) {
        const auto at = plot.from(ImGui::GetIO().MousePos);
        ImGui::SetTooltip("%s",
                          fmt::format("{} {:.4g}, {} {:.3f}", look.xName, at.x, look.yName, at.y).c_str());
    }
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const ImVec2 end{plot.origin.x + plot.size.x, plot.origin.y + plot.size.y};
    draw.AddRectFilled(plot.origin, end, IM_COL32(18, 20, 26, 255));
    draw.PushClipRect(plot.origin, {end.x + knotRadius, end.y + knotRadius}, false);
    drawHistogram(draw, plot, look.histogram, look.histogramRange);
    drawGrid(draw, plot);
    const ImU32 color = look.rootAxis ? IM_COL32(255, 176, 84, 255) : IM_COL32(140, 200, 255, 255);
    drawCurve(draw, plot, curve.knots(), color);
    for (const auto& knot : curve.knots()) draw.AddCircleFilled(plot.at(knot), knotRadius, color);
    draw.PopClipRect();
    if (look.color) drawStrip(draw, plot, look.color);
    ImGui::Dummy({width, stripHeight});
    ImGui::PopID();
    return changed;
}

}  // namespace mote::client
