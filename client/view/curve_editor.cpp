// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/curve_editor.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "protocol/scene/srgb.h"

namespace mote::client {
namespace {

using Which = TransferFunctions::Which;

constexpr float knotRadius = 5.0F, grabRadius = 9.0F, stripHeight = 8.0F;  // pixels

/// Places curve coordinates on the screen. Opacities are small where they matter: their axis is a square
/// root.
struct Plot {
    ImVec2 origin;  // upper left
    ImVec2 size;
    bool rootAxis;

    float up(double y) const { return static_cast<float>(rootAxis ? std::sqrt(y) : y); }
    ImVec2 at(const Curve::Knot& knot) const {
        return {origin.x + static_cast<float>(knot.x) * size.x, origin.y + (1.0F - up(knot.y)) * size.y};
    }
    Curve::Knot from(const ImVec2& screen) const {
        const double x = std::clamp((screen.x - origin.x) / size.x, 0.0F, 1.0F);
        const double y = std::clamp(1.0F - (screen.y - origin.y) / size.y, 0.0F, 1.0F);
        return {x, rootAxis ? y * y : y};
    }
};

void drawHistogram(ImDrawList& draw, const Plot& plot, std::span<const std::uint64_t> bins) {
    const std::uint64_t most = bins.empty() ? 0 : *std::max_element(bins.begin(), bins.end());
    if (most == 0) return;
    const float width = plot.size.x / static_cast<float>(bins.size());
    const float scale = plot.size.y / std::log1p(static_cast<float>(most));
    for (std::size_t i = 0; i < bins.size(); ++i) {
        const float left = plot.origin.x + width * static_cast<float>(i);
        const float bottom = plot.origin.y + plot.size.y;
        const float top = bottom - scale * std::log1p(static_cast<float>(bins[i]));
        draw.AddRectFilled({left, top}, {left + width, bottom}, IM_COL32(92, 104, 122, 150));
    }
}

void drawGrid(ImDrawList& draw, const Plot& plot) {
    const auto line = [&](double y, const char* label) {
        const float height = plot.at({0.0, y}).y;
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

void drawCurve(ImDrawList& draw, const Plot& plot, const Curve& curve, ImU32 color) {
    constexpr int pieces = 160;  // straight pieces are bent by the square-root axis
    for (int i = 0; i <= pieces; ++i) {
        const double x = static_cast<double>(i) / pieces;
        draw.PathLineTo(plot.at({x, curve(x)}));
    }
    draw.PathStroke(color, 0, 2.0F);
}

void drawStrip(ImDrawList& draw, const Plot& plot, const ColorMap& map) {
    constexpr int pieces = 64;
    const float top = plot.origin.y + plot.size.y;
    for (int i = 0; i < pieces; ++i) {
        const auto color = linearToSrgb(map((i + 0.5) / pieces)) * 255.0;
        const float left = plot.origin.x + plot.size.x * static_cast<float>(i) / pieces;
        draw.AddRectFilled(
            {left, top}, {left + plot.size.x / pieces + 1.0F, top + stripHeight},
            IM_COL32(static_cast<int>(color.x), static_cast<int>(color.y), static_cast<int>(color.z), 255));
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
bool edit(const Plot& plot, TransferFunctions& functions, Which which) {
    ImGuiStorage& storage = *ImGui::GetStateStorage();
    const ImGuiID held = ImGui::GetID("held");
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    const auto under = ImGui::IsItemHovered() ? knotAt(plot, functions.knots(which), mouse) : std::nullopt;
    if (under && ImGui::IsMouseClicked(ImGuiMouseButton_Right)) {
        functions.remove(which, *under);
        return true;
    }
    if (ImGui::IsItemActivated()) {
        const auto grabbed = under ? *under : functions.insert(which, plot.from(mouse));
        storage.SetInt(held, static_cast<int>(grabbed));
        return !under;
    }
    const auto& drag = ImGui::GetIO().MouseDelta;
    if (!ImGui::IsItemActive() || (drag.x == 0.0F && drag.y == 0.0F)) return false;
    const auto knot = static_cast<std::size_t>(storage.GetInt(held));
    if (knot >= functions.knots(which).size()) return false;
    functions.move(which, knot, plot.from(mouse));
    return true;
}

}  // namespace

bool curveEditor(const char* id, TransferFunctions& functions, const CurveEditorLook& look) {
    ImGui::PushID(id);
    const float width = ImGui::GetContentRegionAvail().x;
    const Plot plot{ImGui::GetCursorScreenPos(), {width, look.height}, look.which == Which::volume};
    ImGui::InvisibleButton("plot", {width, look.height});
    const bool changed = edit(plot, functions, look.which);
    if (ImGui::IsItemHovered()) {
        const auto at = plot.from(ImGui::GetIO().MousePos);
        ImGui::SetTooltip("%s", fmt::format("log density {:.3f}, {} {:.3f}", at.x,
                                            look.which == Which::volume ? "opacity" : "fraction", at.y)
                                    .c_str());
    }
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const ImVec2 end{plot.origin.x + plot.size.x, plot.origin.y + plot.size.y};
    draw.AddRectFilled(plot.origin, end, IM_COL32(18, 20, 26, 255));
    draw.PushClipRect(plot.origin, {end.x + knotRadius, end.y + knotRadius}, false);
    drawHistogram(draw, plot, look.histogram);
    drawGrid(draw, plot);
    const auto& knots = functions.knots(look.which);
    const ImU32 color =
        look.which == Which::volume ? IM_COL32(255, 176, 84, 255) : IM_COL32(140, 200, 255, 255);
    drawCurve(draw, plot, Curve::create(knots).value(), color);
    for (const auto& knot : knots) draw.AddCircleFilled(plot.at(knot), knotRadius, color);
    draw.PopClipRect();
    if (look.colorMap) drawStrip(draw, plot, *look.colorMap);
    ImGui::Dummy({width, stripHeight});
    ImGui::PopID();
    return changed;
}

}  // namespace mote::client
