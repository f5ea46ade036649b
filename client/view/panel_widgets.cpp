// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/panel_widgets.h"

#include <fmt/format.h>
#include <imgui.h>

namespace mote::client {

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

void angleSliders(const char* name, LightAngles& angles, PanelActions& actions) {
    constexpr auto clamped = ImGuiSliderFlags_AlwaysClamp;
    note(actions, ImGui::SliderFloat(fmt::format("{} across", name).c_str(), &angles.across, -180.0F, 180.0F,
                                     "%.0f deg", clamped));
    note(actions, ImGui::SliderFloat(fmt::format("{} above", name).c_str(), &angles.above, -90.0F, 90.0F,
                                     "%.0f deg", clamped));
}

}  // namespace mote::client
