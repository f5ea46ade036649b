// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/layers/mesh_editor.h"

#include <fmt/format.h>
#include <imgui.h>

#include "client/view/panel_widgets.h"
#include "client/view/server_state.h"
#include "protocol/scene/mesh_style.h"

namespace mote::client {

MeshControls::MeshControls() {
    read({});
}

void MeshControls::write(proto::MeshStyle& style) const {
    assignColor(style.mutable_color(), color);
    style.set_opacity(share(opacity));
    style.set_wire(wire);
    auto& light = *style.mutable_light();
    assign(light.mutable_direction(), angles.direction());
    light.set_ambient(share(ambient));
    light.set_diffuse(share(diffuse));
    light.set_specular(share(specular));
    light.set_shadow(shadow);
}

void MeshControls::read(const proto::MeshStyle& message) {
    const auto style = parseMeshStyle(message).value();
    color = shownColor(message.color(), style.color);
    opacity = static_cast<float>(style.opacity);
    wire = style.wire;
    angles = LightAngles::of(style.light.direction);
    ambient = static_cast<float>(style.light.ambient);
    diffuse = static_cast<float>(style.light.diffuse);
    specular = static_cast<float>(style.light.specular);
    shadow = style.light.shadow;
}

void MeshEditor::drawFacts(const LayerPanel& panel) {
    const auto& mesh = panel.server.shown->manifest().mesh();
    dim(fmt::format("{}, {}", metric(static_cast<double>(mesh.triangles()), "triangles"),
                    metric(static_cast<double>(mesh.vertices()), "vertices")));
}

void MeshEditor::draw(const LayerPanel& panel) {
    if (section("Mesh")) {
        PanelActions& actions = panel.actions;
        colorBox(actions, "colour", controls.color);
        ImGui::SameLine();
        checkbox(actions, "wire", controls.wire);
        slider(actions, "opacity", controls.opacity, 0.0F, 1.0F);
        angleSliders(actions, "light", controls.angles);
        slider(actions, "ambient", controls.ambient, 0.0F, 1.0F);
        slider(actions, "diffuse", controls.diffuse, 0.0F, 1.0F);
        slider(actions, "specular", controls.specular, 0.0F, 1.0F);
        checkbox(actions, "shadow", controls.shadow);
    }
    colorBox(panel.actions, "background", panel.background);
}

}  // namespace mote::client
