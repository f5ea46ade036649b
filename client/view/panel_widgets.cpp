// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/panel_widgets.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

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

bool section(const char* title) {
    return ImGui::CollapsingHeader(title, ImGuiTreeNodeFlags_DefaultOpen);
}

std::string metric(double value, const char* unit) {
    const char* prefix = "";
    for (const char* next : {"k", "M", "G"}) {
        if (value < 1000.0) break;
        value /= 1000.0;
        prefix = next;
    }
    const bool word = unit[0] >= 'a' && unit[0] <= 'z' && prefix[0] != 0;  // "M points", but "MB/s"
    return fmt::format("{:.3g} {}{}{}", value, prefix, word ? " " : "", unit);
}

void note(PanelActions& actions, bool changed) {
    actions.viewChanged |= changed;
    actions.editing |= ImGui::IsItemActive();
}

void noteCurve(PanelActions& actions, bool changed) {
    actions.viewChanged |= changed;
    actions.editing |= ImGui::IsMouseDown(ImGuiMouseButton_Left) && ImGui::IsAnyItemActive();
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

void angleSliders(PanelActions& actions, const char* name, LightAngles& angles) {
    slider(actions, fmt::format("{} across", name).c_str(), angles.across, -180.0F, 180.0F, "%.0f deg");
    slider(actions, fmt::format("{} above", name).c_str(), angles.above, -90.0F, 90.0F, "%.0f deg");
}

void nameList(PanelActions& actions, const char* label, std::string& chosen,
              std::span<const std::string_view> names) {
    note(actions, chooseName(label, chosen, names));
}

}  // namespace mote::client
