// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/panel_widgets.h"

#include <fmt/format.h>
#include <imgui.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "protocol/base/mote_check.h"
#include "protocol/scene/color_map.h"
#include "protocol/scene/fields/facts.h"
#include "protocol/scene/srgb.h"

namespace mote::client {
namespace {

constexpr auto clamped = ImGuiSliderFlags_AlwaysClamp;
constexpr auto exactly = ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_NoRoundToFormat;

}  // namespace

void text(const std::string& line) {
    ImGui::TextUnformatted(line.c_str());
}

void dim(const std::string& line) {
    ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
    ImGui::PushTextWrapPos(0.0F);
    text(line);
    ImGui::PopTextWrapPos();
    ImGui::PopStyleColor();
}

void pushWarningColor() {
    const auto& ground = ImGui::GetStyleColorVec4(ImGuiCol_WindowBg);
    ImGui::PushStyleColor(ImGuiCol_Text,
                          ground.x > 0.5F ? IM_COL32(165, 50, 10, 255) : IM_COL32(255, 160, 120, 255));
}

bool section(const char* title) {
    return ImGui::CollapsingHeader(title, ImGuiTreeNodeFlags_DefaultOpen);
}

std::string metric(double value, const char* unit) {
    const char* prefix = "";
    for (const char* next : {"k", "M", "G", "T"}) {
        if (value < 1000.0) break;
        value /= 1000.0;
        prefix = next;
    }
    const bool word = unit[0] >= 'a' && unit[0] <= 'z' && prefix[0] != 0;  // "M points", but "MB/s"
    return fmt::format("{:.3g} {}{}{}", value, prefix, word ? " " : "", unit);
}

void endByEscape() {
    if (ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape))) ImGui::CloseCurrentPopup();
}

void note(PanelActions& actions, bool changed) {
    actions.viewChanged |= changed;
    actions.editing |= ImGui::IsItemActive();
}

void noteCurve(PanelActions& actions, bool changed) {
    actions.viewChanged |= changed;
    actions.editing |= ImGui::IsMouseDown(ImGuiMouseButton_Left) && ImGui::IsAnyItemActive();
}

void helpAtRest(const std::string& said) {
    constexpr double rest = 0.4;  // seconds
    static ImVec2 place;
    static double since = 0.0;
    if (said.empty() || !ImGui::IsItemHovered()) return;
    const auto& io = ImGui::GetIO();
    const bool moved = io.MousePos.x != place.x || io.MousePos.y != place.y;
    if (moved) since = ImGui::GetTime();
    if (ImGui::IsAnyMouseDown()) since = std::numeric_limits<double>::max();  // until it moves
    place = io.MousePos;
    if (ImGui::GetTime() - since >= rest) ImGui::SetTooltip("%s", said.c_str());
}

void fieldHelp(const google::protobuf::Message& message, int field) {
    const auto* found = message.GetDescriptor()->FindFieldByNumber(field);
    MOTE_CHECK(found != nullptr);
    helpAtRest(factsOf(*found).help());
}

bool chooseName(const char* label, std::string& chosen, std::span<const std::string_view> names) {
    bool changed = false;
    if (!ImGui::BeginCombo(label, chosen.c_str())) return false;
    for (const std::string_view name : names) {
        if (ImGui::Selectable(std::string(name).c_str(), name == chosen) && name != chosen) {
            chosen = name;
            changed = true;
        }
    }
    ImGui::EndCombo();
    return changed;
}

void checkbox(PanelActions& actions, const char* label, bool& value) {
    note(actions, ImGui::Checkbox(label, &value));
}

void colorBox(PanelActions& actions, const char* label, std::array<float, 3>& color) {
    note(actions, ImGui::ColorEdit3(label, color.data(), ImGuiColorEditFlags_NoInputs));
}

void backgroundBox(PanelActions& actions, std::array<float, 3>& color) {
    colorBox(actions, "background", color);
    fieldHelp(proto::View::default_instance(), proto::View::kBackgroundFieldNumber);
}

void slider(PanelActions& actions, const char* label, float& value, float least, float most,
            const char* format) {
    note(actions, ImGui::SliderFloat(label, &value, least, most, format, clamped));
}

void logSlider(PanelActions& actions, const char* label, float& value, float least, float most,
               const char* format) {
    note(actions,
         ImGui::SliderFloat(label, &value, least, most, format, clamped | ImGuiSliderFlags_Logarithmic));
}

std::string formatFor(double span, double place) {
    constexpr int least = 4, most = 17;  // digits
    const double digits = std::log10(std::abs(place) / span) + least;
    return fmt::format("%.{}g", std::isfinite(digits)
                                    ? static_cast<int>(std::clamp(digits, 1.0 * least, 1.0 * most))
                                    : least);
}

void rangeBox(PanelActions& actions, const char* label, double& low, double& high, const Interval& ends,
              double parts) {
    const auto format =
        formatFor(std::min(high - low, ends.high - ends.low), std::max(std::abs(low), std::abs(high)));
    const float speed = static_cast<float>((ends.high - ends.low) / parts);
    const float gap = ImGui::GetStyle().ItemInnerSpacing.x, width = 0.5F * (ImGui::CalcItemWidth() - gap);
    double first = low, second = high;
    const auto drag = [&](const char* name, double& value, double least, double most) {
        ImGui::SetNextItemWidth(width);
        note(actions, ImGui::DragScalar(name, ImGuiDataType_Double, &value, speed, &least, &most,
                                        format.c_str(), exactly));
        ImGui::SameLine(0.0F, gap);
    };
    ImGui::PushID(label);
    drag("##low", first, std::min(ends.low, low), high);
    drag("##high", second, low, std::max(ends.high, high));
    ImGui::PopID();
    text(label);
    if (!(first < second)) return;  // that would be no range
    low = first;
    high = second;
}

void wideSlider(PanelActions& actions, const char* label, double& value, const Interval& ends) {
    const auto format = formatFor(ends.high - ends.low, std::max(std::abs(ends.low), std::abs(ends.high)));
    note(actions, ImGui::SliderScalar(label, ImGuiDataType_Double, &value, &ends.low, &ends.high,
                                      format.c_str(), ImGuiSliderFlags_NoRoundToFormat));
}

bool typeNumbers(const char* label, glm::dvec3& numbers) {
    return ImGui::InputScalarN(label, ImGuiDataType_Double, &numbers[0], 3, nullptr, nullptr, "%.6g",
                               ImGuiInputTextFlags_EnterReturnsTrue);
}

void angleSliders(PanelActions& actions, const char* name, LightAngles& angles) {
    slider(actions, fmt::format("{} across", name).c_str(), angles.across, -180.0F, 180.0F, "%.0f deg");
    slider(actions, fmt::format("{} above", name).c_str(), angles.above, -90.0F, 90.0F, "%.0f deg");
}

void nameList(PanelActions& actions, const char* label, std::string& chosen,
              std::span<const std::string_view> names) {
    note(actions, chooseName(label, chosen, names));
}

bool chooseColorMap(const char* label, std::string& chosen) {
    bool changed = false;
    if (!ImGui::BeginCombo(label, chosen.c_str(), ImGuiComboFlags_HeightLarge)) return false;
    constexpr int pieces = 32;
    const float letter = ImGui::GetFontSize(), width = 6.0F * letter / pieces;
    for (const std::string_view name : ColorMap::names()) {
        const auto map = ColorMap::find(name);
        const ImVec2 at = ImGui::GetCursorScreenPos();
        for (int i = 0; map.ok() && i < pieces; ++i) {
            const auto color = linearToSrgb((*map)((i + 0.5) / pieces));
            const ImVec4 shown(static_cast<float>(color.x), static_cast<float>(color.y),
                               static_cast<float>(color.z), 1.0F);
            const float left = at.x + width * static_cast<float>(i);
            ImGui::GetWindowDrawList()->AddRectFilled({left, at.y}, {left + width + 1.0F, at.y + letter},
                                                      ImGui::ColorConvertFloat4ToU32(shown));
        }
        ImGui::Dummy({6.5F * letter, letter});
        ImGui::SameLine();
        if (!ImGui::Selectable(std::string(name).c_str(), name == chosen) || name == chosen) continue;
        chosen = name;
        changed = true;
    }
    ImGui::EndCombo();
    return changed;
}

void colorMapList(PanelActions& actions, const char* label, std::string& chosen) {
    note(actions, chooseColorMap(label, chosen));
}

namespace {

/// Screen coordinates of so many at the usual size of letters.
float inProportion(float coordinates) {
    return coordinates * ImGui::GetFontSize() / 14.0F;
}
float knotRadius() {
    return inProportion(5.0F);
}
float stripHeight() {
    return inProportion(8.0F);
}

/// Places curve coordinates on the screen. Opacities are small where they matter: their axis is a square
/// root.
struct Plot {
    ImVec2 origin;  // upper left
    ImVec2 size;
    Interval axis;
    bool rootAxis;
    double bend;

    /// A share of the axis, of the width, and back.
    double bent(double share) const {
        return bend > 0.0 ? std::expm1(bend * share) / std::expm1(bend) : share;
    }
    double unbent(double share) const {
        return bend > 0.0 ? std::log1p(share * std::expm1(bend)) / bend : share;
    }

    float up(double y) const { return static_cast<float>(rootAxis ? std::sqrt(y) : y); }
    float across(double x) const {
        return origin.x + static_cast<float>(bent((x - axis.low) / (axis.high - axis.low))) * size.x;
    }
    ImVec2 at(const Curve::Knot& knot) const {
        return {across(knot.x), origin.y + (1.0F - up(knot.y)) * size.y};
    }
    Curve::Knot from(const ImVec2& screen) const {
        const double x = unbent(std::clamp((screen.x - origin.x) / size.x, 0.0F, 1.0F));
        const double y = std::clamp(1.0F - (screen.y - origin.y) / size.y, 0.0F, 1.0F);
        return {axis.low + x * (axis.high - axis.low), rootAxis ? y * y : y};
    }
};

/// `most`: what fills the height.
void drawHistogram(ImDrawList& draw, const Plot& plot, std::span<const std::uint64_t> bins,
                   const Interval& range, std::uint64_t most, ImU32 color) {
    if (most == 0) return;
    const double width = (range.high - range.low) / static_cast<double>(bins.size());
    const float scale = plot.size.y / std::log1p(static_cast<float>(most));
    for (std::size_t i = 0; i < bins.size(); ++i) {
        if (bins[i] == 0) continue;
        const float left = plot.across(range.low + width * static_cast<double>(i));
        const float right = plot.across(range.low + width * static_cast<double>(i + 1));
        const float bottom = plot.origin.y + plot.size.y;
        const float top = bottom - scale * std::log1p(static_cast<float>(bins[i]));
        draw.AddRectFilled({left, top}, {std::max(right, left + 1.0F), bottom}, color);
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
    // A list of Dear ImGui has 65536 vertices at most.
    const int pieces = std::clamp(1024 / static_cast<int>(knots.size()), 2, 24);
    draw.PathLineTo(plot.at({plot.axis.low, knots.front().y}));
    for (std::size_t i = 0; i < knots.size(); ++i) {
        const auto& from = knots[i > 0 ? i - 1 : 0];
        for (int piece = 1; piece <= pieces; ++piece) {
            const double share = static_cast<double>(piece) / pieces;
            draw.PathLineTo(
                plot.at({std::lerp(from.x, knots[i].x, share), std::lerp(from.y, knots[i].y, share)}));
        }
    }
    draw.PathLineTo(plot.at({plot.axis.high, knots.back().y}));
    draw.PathStroke(color, 0, std::round(inProportion(2.0F)));
}

void drawStrip(ImDrawList& draw, const Plot& plot, const std::function<glm::dvec3(double)>& color) {
    constexpr int pieces = 128;
    const float top = plot.origin.y + plot.size.y;
    for (int i = 0; i < pieces; ++i) {
        const double x = std::lerp(plot.axis.low, plot.axis.high, plot.unbent((i + 0.5) / pieces));
        const auto shown = linearToSrgb(color(x)) * 255.0;
        const float left = plot.origin.x + plot.size.x * static_cast<float>(i) / pieces;
        draw.AddRectFilled(
            {left, top}, {left + plot.size.x / pieces + 1.0F, top + stripHeight()},
            IM_COL32(static_cast<int>(shown.x), static_cast<int>(shown.y), static_cast<int>(shown.z), 255));
    }
}

std::optional<std::size_t> knotAt(const Plot& plot, const std::vector<Curve::Knot>& knots,
                                  const ImVec2& mouse) {
    std::optional<std::size_t> best;
    float nearest = inProportion(9.0F) * inProportion(9.0F);
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

/// The numbers of the knot that was last taken hold of.
bool typeKnot(EditedCurve& curve, const CurveEditorLook& look, float width) {
    const int held = ImGui::GetStateStorage()->GetInt(ImGui::GetID("held"), -1);
    if (held < 0 || static_cast<std::size_t>(held) >= curve.knots().size()) return false;
    auto knot = curve.knots()[static_cast<std::size_t>(held)];
    bool typed = false;
    const float each = 0.25F * width;
    for (const auto& [name, value] : {std::pair{look.xName, &knot.x}, {look.yName, &knot.y}}) {
        ImGui::SetNextItemWidth(each);
        typed |= ImGui::InputDouble(name, value, 0.0, 0.0, "%.6g", ImGuiInputTextFlags_EnterReturnsTrue);
        if (value == &knot.x) ImGui::SameLine();
    }
    if (typed) curve.move(static_cast<std::size_t>(held), knot);
    return typed;
}

}  // namespace

bool curveEditor(const char* id, EditedCurve& curve, const CurveEditorLook& look) {
    ImGui::PushID(id);
    const float width = ImGui::GetContentRegionAvail().x;
    const Plot plot{ImGui::GetCursorScreenPos(), {width, look.height}, look.axis, look.rootAxis, look.bend};
    ImGui::InvisibleButton("plot", {width, look.height});
    bool changed = edit(plot, curve);
    if (ImGui::IsItemHovered()) {
        const auto at = plot.from(ImGui::GetIO().MousePos);
        const auto x = look.said ? look.said(at.x) : fmt::format("{} {:.4g}", look.xName, at.x);
        ImGui::SetTooltip("%s", fmt::format("{}, {} {:.3f}", x, look.yName, at.y).c_str());
    }
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const ImVec2 end{plot.origin.x + plot.size.x, plot.origin.y + plot.size.y};
    draw.AddRectFilled(plot.origin, end, IM_COL32(18, 20, 26, 255));
    // Knots stand out at the sides, but not over what lies above or below the window.
    const float top = std::max(plot.origin.y, draw.GetClipRectMin().y),
                bottom = std::min(end.y + knotRadius(), draw.GetClipRectMax().y);
    draw.PushClipRect({plot.origin.x, top}, {end.x + knotRadius(), bottom}, false);
    const std::uint64_t most = look.histogram.empty() ? 0 : *std::ranges::max_element(look.histogram);
    drawHistogram(draw, plot, look.histogram, look.histogramRange, most, IM_COL32(92, 104, 122, 150));
    if (look.lit.size() == look.histogram.size())
        drawHistogram(draw, plot, look.lit, look.histogramRange, most, IM_COL32(255, 225, 130, 200));
    drawGrid(draw, plot);
    const ImU32 color = look.rootAxis ? IM_COL32(255, 176, 84, 255) : IM_COL32(140, 200, 255, 255);
    drawCurve(draw, plot, curve.knots(), color);
    for (const auto& knot : curve.knots()) draw.AddCircleFilled(plot.at(knot), knotRadius(), color);
    draw.PopClipRect();
    if (look.color) drawStrip(draw, plot, look.color);
    ImGui::Dummy({width, stripHeight()});
    changed |= typeKnot(curve, look, width);
    ImGui::PopID();
    return changed;
}

}  // namespace mote::client
