// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/layers/ink_editor.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <string_view>

#include "client/view/panel_widgets.h"
#include "client/view/server_state.h"
#include "protocol/scene/ink_style.h"

namespace mote::client {
namespace {

constexpr const char* theDrawing = "drawing";
constexpr std::array<std::string_view, 4> modes{"adjusted", "important", "all", "none"};
constexpr std::array<std::string_view, 4> segmentations{"growing", "graph", "cut", "texture"};
constexpr std::array<std::string_view, 10> pictures{theDrawing,   "grey",     "depth",  "angle",   "edges",
                                                    "complexity", "segments", "target", "lighten", "darken"};

/// Where a view says none.
float importanceOf(const std::string& lines) {
    proto::InkStyle message;
    message.mutable_silhouettes()->set_mode(lines);
    const auto style = parseInkStyle(message, glm::dvec3(1.0)).value();
    return static_cast<float>(style.silhouettes.importance);
}

void drawLines(InkControls& controls, PanelActions& actions) {
    if (!section("Lines")) return;
    std::string chosen = controls.lines;
    nameList(actions, "silhouettes", chosen, modes);
    if (chosen != controls.lines) controls.setLines(chosen);
    slider(actions, "importance", controls.importance, 0.0F, 1.0F);
    slider(actions, "width", controls.lineWidth, 0.1F, 8.0F);
    slider(actions, "creases from", controls.crease, 0.0F, 180.0F, "%.0f degrees");
    checkbox(actions, "none between contrasts", controls.omit);
    slider(actions, "reading distance", controls.reading, 1.0F, 64.0F, "%.1f pixels");
}

void drawHatches(InkControls& controls, PanelActions& actions) {
    if (!section("Hatching")) return;
    slider(actions, "strength", controls.hatch, 0.0F, 1.0F);
    slider(actions, "spacing", controls.spacing, 1.0F, 32.0F, "%.1f pixels");
    slider(actions, "width##hatch", controls.hatchWidth, 0.1F, 8.0F);
    nameList(actions, "regions", controls.segments, segmentations);
}

std::string factsOf(const proto::Manifest& manifest) {
    if (manifest.has_hybrid()) return fmt::format("{}", fmt::join(manifest.hybrid().source_size(), " x "));
    if (manifest.has_mesh()) return metric(static_cast<double>(manifest.mesh().triangles()), "triangles");
    double particles = 0.0;
    for (const auto& step : manifest.particles().steps()) particles += static_cast<double>(step.particles());
    return metric(particles, "particles");
}

}  // namespace

InkControls::InkControls() {
    read({});
}

void InkControls::write(proto::InkStyle& style) const {
    auto& silhouettes = *style.mutable_silhouettes();
    silhouettes.set_mode(lines);
    silhouettes.clear_importance();
    if (!importanceByLines_ || importance != importanceOf(lines))
        silhouettes.set_importance(share(importance));
    silhouettes.set_width(decimal(lineWidth));
    silhouettes.set_crease_degrees(decimal(crease));
    silhouettes.set_omit(omit);
    style.mutable_hatch()->set_strength(share(hatch));
    style.mutable_hatch()->set_spacing(decimal(spacing));
    style.mutable_hatch()->set_width(decimal(hatchWidth));
    style.mutable_hatch()->set_segments(segments);
    writeSolid(style);
    style.set_reading(decimal(reading));
    style.set_occlusion(share(occlusion));
    style.set_waver(decimal(waver));
    style.set_taper(taper);
    style.set_coherent(coherent);
    style.set_show(show == theDrawing ? "" : show);
    auto& light = *style.mutable_light();
    assign(light.mutable_direction(), angles.direction());
    light.set_ambient(share(ambient));
    light.set_diffuse(share(diffuse));
    light.set_shadow(shadow);
}

/// Where it is there and says nothing, it is not what it is where it is not there.
void InkControls::writeSolid(proto::InkStyle& style) const {
    const SolidStyle none;
    style.clear_ink();
    if (!ownSolid_ && share(solid) == none.strength && share(complexity) == none.complexity) return;
    style.mutable_ink()->set_strength(share(solid));
    style.mutable_ink()->set_complexity(share(complexity));
}

void InkControls::setLines(const std::string& mode) {
    if (importanceByLines_ && importance == importanceOf(lines)) importance = importanceOf(mode);
    lines = mode;
}

void InkControls::read(const proto::InkStyle& message) {
    const auto style = parseInkStyle(message, glm::dvec3(1.0)).value();
    lines = toString(style.silhouettes.mode);
    importance = static_cast<float>(style.silhouettes.importance);
    importanceByLines_ = !message.silhouettes().has_importance();
    lineWidth = static_cast<float>(style.silhouettes.width);
    crease = static_cast<float>(style.silhouettes.crease);
    omit = style.silhouettes.omit;
    hatch = static_cast<float>(style.hatch.strength);
    spacing = static_cast<float>(style.hatch.spacing);
    hatchWidth = static_cast<float>(style.hatch.width);
    segments = toString(style.hatch.segments);
    ownSolid_ = message.has_ink();
    solid = static_cast<float>(style.solid.strength);
    complexity = static_cast<float>(style.solid.complexity);
    occlusion = static_cast<float>(style.occlusion);
    reading = static_cast<float>(style.reading);
    waver = static_cast<float>(style.waver);
    taper = style.taper;
    coherent = style.coherent;
    show = style.show == InkPicture::drawing ? theDrawing : toString(style.show);
    angles = LightAngles::of(style.light.direction);
    ambient = static_cast<float>(style.light.ambient);
    diffuse = static_cast<float>(style.light.diffuse);
    shadow = style.light.shadow;
}

void InkEditor::drawFacts(const LayerPanel& panel) {
    dim(factsOf(panel.server.shown->manifest()));
}

void InkEditor::draw(const LayerPanel& panel) {
    PanelActions& actions = panel.actions;
    drawLines(controls, actions);
    drawHatches(controls, actions);
    if (section("Brush")) {
        slider(actions, "strength##solid", controls.solid, 0.0F, 1.0F);
        slider(actions, "where complex from", controls.complexity, 0.0F, 1.0F);
    }
    if (section("Ink")) {
        nameList(actions, "show", controls.show, pictures);
        slider(actions, "waver", controls.waver, 0.0F, 8.0F, "%.1f pixels");
        checkbox(actions, "taper", controls.taper);
        checkbox(actions, "coherent", controls.coherent);
        angleSliders(actions, "light", controls.angles);
        slider(actions, "ambient", controls.ambient, 0.0F, 1.0F);
        slider(actions, "diffuse", controls.diffuse, 0.0F, 1.0F);
        slider(actions, "occlusion", controls.occlusion, 0.0F, 1.0F);
        checkbox(actions, "shadow", controls.shadow);
    }
    colorBox(actions, "paper", panel.background);
}

}  // namespace mote::client
