// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/stipple_panel.h"

#include <imgui.h>

#include "client/view/panel_widgets.h"

namespace mote::client {
namespace {

constexpr auto clamped = ImGuiSliderFlags_AlwaysClamp;
constexpr auto logarithmic = clamped | ImGuiSliderFlags_Logarithmic;

void drawDots(StippleControls& controls, PanelActions& actions) {
    note(actions, ImGui::SliderFloat("spacing", &controls.spacing, 1.5F, 40.0F, "%.1f px", logarithmic));
    note(actions, ImGui::SliderFloat("dot", &controls.dotSize, 0.5F, 16.0F, "%.1f px", logarithmic));
    note(actions, ImGui::Checkbox("own colour", &controls.ownColor));
    if (controls.ownColor) {
        ImGui::SameLine();
        note(actions, ImGui::ColorEdit3("colour", controls.color.data(), ImGuiColorEditFlags_NoInputs));
    }
    ImGui::SameLine();
    note(actions, ImGui::Checkbox("invert", &controls.invert));
    note(actions, ImGui::SliderFloat("gamma", &controls.gamma, 0.25F, 4.0F, "%.2f", logarithmic));
}

void drawSurface(StippleControls& controls, PanelActions& actions) {
    angleSliders("light", controls.angles, actions);
    note(actions, ImGui::SliderFloat("ambient", &controls.ambient, 0.0F, 1.0F, "%.2f", clamped));
    note(actions, ImGui::Checkbox("shadow", &controls.shadow));
    ImGui::SameLine();
    note(actions, ImGui::Checkbox("see through", &controls.seeThrough));
    note(actions, ImGui::SliderFloat("edge jitter", &controls.jitter, 0.0F, 2.0F, "%.2f", clamped));
    note(actions, ImGui::Checkbox("soft: fade and glide", &controls.soft));
}

void drawImage(StippleControls& controls, const std::vector<std::string_view>& images,
               PanelActions& actions) {
    note(actions, chooseName("image", controls.image, images));
}

}  // namespace

void drawStipple(StippleControls& controls, bool plane, const std::vector<std::string_view>& images,
                 PanelActions& actions) {
    if (!ImGui::CollapsingHeader("Stipple", ImGuiTreeNodeFlags_DefaultOpen)) return;
    drawDots(controls, actions);
    if (plane) {
        drawImage(controls, images, actions);
    } else {
        drawSurface(controls, actions);
    }
}

}  // namespace mote::client
