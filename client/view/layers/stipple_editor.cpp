// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/layers/stipple_editor.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <glm/vec3.hpp>
#include <vector>

#include "client/view/panel_widgets.h"
#include "client/view/server_state.h"
#include "protocol/scene/stipple_style.h"

namespace mote::client {
namespace {

void drawDots(StippleControls& controls, PanelActions& actions) {
    logSlider(actions, "spacing", controls.spacing, 1.5F, 40.0F, "%.1f px");
    logSlider(actions, "dot", controls.dotSize, 0.5F, 16.0F, "%.1f px");
    checkbox(actions, "own colour", controls.ownColor);
    if (controls.ownColor) {
        ImGui::SameLine();
        colorBox(actions, "colour", controls.color);
    }
    ImGui::SameLine();
    checkbox(actions, "invert", controls.invert);
    logSlider(actions, "gamma", controls.gamma, 0.25F, 4.0F, "%.2f");
}

void drawSurface(StippleControls& controls, PanelActions& actions) {
    angleSliders(actions, "light", controls.angles);
    slider(actions, "ambient", controls.ambient, 0.0F, 1.0F);
    slider(actions, "diffuse", controls.diffuse, 0.0F, 1.0F);
    checkbox(actions, "shadow", controls.shadow);
    ImGui::SameLine();
    checkbox(actions, "see through", controls.seeThrough);
    slider(actions, "edge jitter", controls.jitter, 0.0F, 2.0F);
    checkbox(actions, "soft: fade and glide", controls.soft);
}

/// A hierarchy on the plane takes its tones from an image of the catalogue.
void drawPlane(StippleControls& controls, const proto::Catalogue& catalogue, PanelActions& actions) {
    std::vector<std::string_view> images;
    for (const auto& entry : catalogue.datasets()) {
        if (entry.kind() == "image") images.emplace_back(entry.name());
    }
    nameList(actions, "image", controls.image, images);
}

}  // namespace

StippleControls::StippleControls() {
    read({});
}

void StippleControls::write(proto::StippleStyle& style) const {
    style.set_spacing_pixels(decimal(std::clamp(spacing, 0.5F, 1000.0F)));
    style.set_dot_pixels(decimal(std::clamp(dotSize, 0.1F, 64.0F)));
    style.clear_color();
    if (ownColor) assignColor(style.mutable_color(), color);
    auto& light = *style.mutable_light();
    assign(light.mutable_direction(), angles.direction());
    light.set_ambient(share(ambient));
    light.set_diffuse(share(diffuse));
    light.set_shadow(shadow);
    style.set_jitter(decimal(std::clamp(jitter, 0.0F, 4.0F)));
    style.set_soft(soft);
    style.set_see_through(seeThrough);
    style.set_invert(invert);
    style.set_gamma(decimal(std::clamp(gamma, 0.05F, 20.0F)));
    style.set_image(image);
}

void StippleControls::read(const proto::StippleStyle& message) {
    const auto style = parseStippleStyle(message, glm::dvec3(0.0)).value();
    spacing = static_cast<float>(style.spacing);
    dotSize = static_cast<float>(style.dotSize);
    ownColor = !message.color().empty();
    color = shownColor(message.color(), style.color);
    angles = LightAngles::of(style.light.direction);
    ambient = static_cast<float>(style.light.ambient);
    diffuse = static_cast<float>(style.light.diffuse);
    shadow = style.light.shadow;
    jitter = static_cast<float>(style.jitter);
    soft = style.soft;
    seeThrough = style.seeThrough;
    invert = message.invert();
    gamma = static_cast<float>(style.gamma);
    image = style.image;
}

void StippleEditor::drawFacts(const LayerPanel& panel) {
    const auto& stipple = panel.server.shown->manifest().stipple();
    dim(fmt::format("{}, {} moves, {} locked", metric(static_cast<double>(stipple.points()), "points"),
                    stipple.moves(), stipple.locked()));
}

void StippleEditor::draw(const LayerPanel& panel) {
    if (section("Stipple")) {
        const auto& shown = panel.server.shown;
        drawDots(controls, panel.actions);
        if (shown && shown->manifest().stipple().domain() == proto::StippleManifest::PLANE) {
            drawPlane(controls, panel.server.catalogue, panel.actions);
        } else {
            drawSurface(controls, panel.actions);
        }
    }
    colorBox(panel.actions, "background", panel.background);
}

}  // namespace mote::client
