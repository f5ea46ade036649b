// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/layers/mesh_editor.h"

#include <fmt/format.h>

#include "client/view/layers/field_controls.h"
#include "client/view/panel_widgets.h"
#include "client/view/server_state.h"

namespace mote::client {

void MeshEditor::drawFacts(const LayerPanel& panel) {
    const auto& mesh = panel.server.shown->manifest().mesh();
    dim(fmt::format("{}, {}", metric(static_cast<double>(mesh.triangles()), "triangles"),
                    metric(static_cast<double>(mesh.vertices()), "vertices")));
}

void MeshEditor::draw(const LayerPanel& panel) {
    if (section("Mesh")) fieldControls(panel.actions, style, resolved(style).value());
    colorBox(panel.actions, "background", panel.background);
}

}  // namespace mote::client
