// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/layers/ink_editor.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <set>
#include <string_view>

#include "client/view/layers/field_controls.h"
#include "client/view/panel_widgets.h"
#include "client/view/server_state.h"
#include "protocol/scene/ink_style.h"
#include "protocol/scene/srgb.h"

namespace mote::client {
namespace {

std::string factsOf(const proto::Manifest& manifest) {
    if (manifest.has_hybrid()) return fmt::format("{}", fmt::join(manifest.hybrid().source_size(), " x "));
    if (manifest.has_mesh()) return metric(static_cast<double>(manifest.mesh().triangles()), "triangles");
    double particles = 0.0;
    for (const auto& step : manifest.particles().steps()) particles += static_cast<double>(step.particles());
    return metric(particles, "particles");
}

}  // namespace

void InkEditor::drawFacts(const LayerPanel& panel) {
    dim(factsOf(panel.server.shown->manifest()));
}

void InkEditor::draw(const LayerPanel& panel) {
    const auto& paper = panel.background;
    const auto shown = parseInkStyle(style, srgbToLinear(glm::dvec3(paper[0], paper[1], paper[2]))).value();
    std::set<std::string_view> drawn;
    const auto drawThese = [&](const char* title, const std::set<std::string_view>& names) {
        drawn.insert(names.begin(), names.end());
        if (section(title))
            fieldControls(panel.actions, style, shown, [&](std::string_view name) {
                return names.contains(name.substr(0, name.find('.')));
            });
    };
    drawThese("Lines", {"silhouettes", "reading"});
    drawThese("Hatching", {"hatch"});
    drawThese("Brush", {"ink"});
    drawThese("Watercolour", {"wash"});
    if (section("Ink"))
        fieldControls(panel.actions, style, shown,
                      [&](std::string_view name) { return !drawn.contains(name.substr(0, name.find('.'))); });
    colorBox(panel.actions, "paper", panel.background);
}

}  // namespace mote::client
