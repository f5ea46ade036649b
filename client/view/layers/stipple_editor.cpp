// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/layers/stipple_editor.h"

#include <fmt/format.h>

#include <set>
#include <string_view>
#include <vector>

#include "client/view/layers/field_controls.h"
#include "client/view/panel_widgets.h"
#include "client/view/server_state.h"
#include "protocol/scene/srgb.h"
#include "protocol/scene/stipple_style.h"

namespace mote::client {
namespace {

const std::set<std::string_view> ofPlanes{"image", "source"};
const std::set<std::string_view> ofSurfaces{"light",      "jitter", "soft",    "leastDotPixels",
                                            "seeThrough", "value",  "colorMap"};

}  // namespace

void StippleEditor::drawFacts(const LayerPanel& panel) {
    const auto& stipple = panel.server.shown->manifest().stipple();
    dim(fmt::format("{}, {} moves, {} locked", metric(static_cast<double>(stipple.points()), "points"),
                    stipple.moves(), stipple.locked()));
}

/// A hierarchy on the plane takes its tones from an image of the catalogue.
void StippleEditor::drawImage(const LayerPanel& panel) {
    std::vector<std::string_view> images;
    for (const auto& entry : panel.server.catalogue.datasets()) {
        if (entry.kind() == "image") images.emplace_back(entry.name());
    }
    nameList(panel.actions, "image", *style.mutable_image(), images);
    if (!style.image().empty()) style.clear_source();
}

void StippleEditor::draw(const LayerPanel& panel) {
    if (section("Stipple")) {
        const auto& shown = panel.server.shown;
        const bool plane = shown && shown->manifest().stipple().domain() == proto::StippleManifest::PLANE;
        const auto paper =
            srgbToLinear(glm::dvec3(panel.background[0], panel.background[1], panel.background[2]));
        fieldControls(panel.actions, style, parseStippleStyle(style, paper).value(),
                      [&](std::string_view name) { return !(plane ? ofSurfaces : ofPlanes).contains(name); });
        if (plane) drawImage(panel);
    }
    colorBox(panel.actions, "background", panel.background);
}

}  // namespace mote::client
