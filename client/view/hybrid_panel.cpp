// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/hybrid_panel.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <imgui.h>

#include <algorithm>
#include <cstdlib>

#include "client/view/curve_editor.h"
#include "client/view/panel_widgets.h"
#include "protocol/scene/color_map.h"
#include "protocol/scene/hybrid_style.h"

namespace mote::client {
namespace {

constexpr auto clamped = ImGuiSliderFlags_AlwaysClamp;
constexpr const char* bestName = "best";  // for the empty name

const proto::HybridStepEntry* stepOf(const proto::HybridManifest& manifest, std::uint32_t step) {
    const auto index = static_cast<int>(step);
    return index < manifest.steps_size() ? &manifest.steps(index) : nullptr;
}

/// As render::hybridParts.
bool drawsResidual(const HybridControls& controls, const proto::HybridManifest& manifest) {
    const auto& asked = controls.representation;
    return manifest.residual() && (asked.empty() || asked == "residual");
}

bool drawsPoints(const HybridControls& controls, const proto::HybridManifest& manifest) {
    const auto& asked = controls.representation;
    return manifest.point_bytes() > 0 && (asked == "points" || (asked.empty() && !manifest.residual()));
}

/// "i16" has 16 bits.
double sourceBytes(const proto::HybridManifest& manifest) {
    double bytes = std::atof(manifest.scalar_type().substr(1).c_str()) / 8.0;
    for (const auto side : manifest.source_size()) bytes *= side;
    return bytes;
}

/// Of one step.
double storedBytes(const proto::Manifest& manifest, const proto::HybridStepEntry& step) {
    double bytes = 0.0;
    for (const auto& file : manifest.files()) {
        const bool own = file.name() == step.file() || file.name() == step.residual_file();
        bytes += own ? static_cast<double>(file.size()) : 0.0;
    }
    return bytes;
}

void drawPresets(HybridControls& controls, const proto::HybridManifest& manifest, PanelActions& actions) {
    if (!ImGui::BeginCombo("preset", "choose a curve")) return;
    for (const auto& preset : HybridControls::presets(manifest)) {
        if (!ImGui::Selectable(std::string(preset.name).c_str())) continue;
        controls.curve.take(preset);
        actions.viewChanged = true;
    }
    ImGui::EndCombo();
}

/// Of a colour map, or of the knot that was last taken hold of.
void drawColors(HybridControls& controls, PanelActions& actions) {
    if (auto* color = controls.curve.chosenColor()) {
        note(actions, ImGui::ColorEdit3("knot's colour", color->data(), ImGuiColorEditFlags_NoInputs));
        ImGui::SameLine();
        if (ImGui::Button("Use a colour map")) {
            controls.curve.dropColors();
            actions.viewChanged = true;
        }
        return;
    }
    note(actions, chooseName("colours", controls.colorMap, ColorMap::names()));
    note(actions, ImGui::Checkbox("own range of colours", &controls.ownColorRange));
    if (!controls.ownColorRange) return;
    const Interval axis = controls.curve.axis();
    const auto low = static_cast<float>(axis.low), high = static_cast<float>(axis.high);
    auto& range = controls.colorRange;
    note(actions, ImGui::DragFloatRange2("range", &range[0], &range[1], (high - low) / 500.0F, low, high,
                                         "%.4g", nullptr, clamped));
}

void drawCurve(HybridControls& controls, const proto::HybridManifest& manifest, std::uint32_t step,
               PanelActions& actions, float scale) {
    if (!ImGui::CollapsingHeader("Transfer function", ImGuiTreeNodeFlags_DefaultOpen)) return;
    const std::string unit = manifest.value_unit().empty() ? "value" : manifest.value_unit();
    CurveEditorLook look{
        .xName = unit.c_str(), .yName = "opacity", .rootAxis = true, .height = 150.0F * scale};
    look.axis = controls.curve.axis();
    look.histogramRange = {manifest.value_min(), manifest.value_max()};
    if (const auto* shown = stepOf(manifest, step)) {
        look.histogram = {shown->histogram().data(), static_cast<std::size_t>(shown->histogram_size())};
    }
    look.color = [&](double value) { return controls.color(value); };
    text(fmt::format("opacity over {}", manifest.value_unit().empty() ? "values" : manifest.value_unit()));
    note(actions, curveEditor("curve", controls.curve, look));
    actions.editing |= ImGui::IsMouseDown(ImGuiMouseButton_Left) && ImGui::IsAnyItemActive();
    dim(fmt::format("{:.5g} to {:.5g}", look.axis.low, look.axis.high));
    drawPresets(controls, manifest, actions);
    drawColors(controls, actions);
}

void drawRepresentation(HybridControls& controls, const proto::HybridManifest& manifest,
                        PanelActions& actions) {
    if (!ImGui::CollapsingHeader("Representation", ImGuiTreeNodeFlags_DefaultOpen)) return;
    std::vector<std::string_view> names{bestName, "volume"};
    if (manifest.point_bytes() > 0) names.emplace_back("points");
    if (manifest.residual()) names.emplace_back("residual");
    std::string chosen = controls.representation.empty() ? bestName : controls.representation;
    note(actions, chooseName("drawn", chosen, names));
    controls.representation = chosen == bestName ? "" : chosen;
    if (!drawsPoints(controls, manifest)) return;
    constexpr std::array<std::string_view, 3> shapes{"gaussian", "disc", "square"};
    note(actions, chooseName("point shape", controls.pointShape, shapes));
    note(actions, ImGui::SliderFloat("correction", &controls.pointOpacity, 0.0F, 1.0F, "%.2f", clamped));
}

void drawLight(HybridControls& controls, PanelActions& actions) {
    if (!ImGui::CollapsingHeader("Light", ImGuiTreeNodeFlags_DefaultOpen)) return;
    angleSliders("light", controls.light, actions);
    note(actions, ImGui::SliderFloat("ambient", &controls.ambient, 0.0F, 1.0F, "%.2f", clamped));
    note(actions, ImGui::SliderFloat("diffuse", &controls.diffuse, 0.0F, 1.0F, "%.2f", clamped));
    note(actions, ImGui::SliderFloat("specular", &controls.specular, 0.0F, 1.0F, "%.2f", clamped));
    note(actions, ImGui::Checkbox("stays where it is", &controls.fixedLight));
}

void drawClipBox(HybridControls& controls, const Bounds& bounds, PanelActions& actions) {
    note(actions, ImGui::Checkbox("box", &controls.clipBox));
    if (!controls.clipBox) return;
    constexpr std::array<const char*, 3> axes{"x", "y", "z"};
    for (std::size_t i = 0; i < axes.size(); ++i) {
        const auto axis = static_cast<glm::length_t>(i);
        const auto low = static_cast<float>(bounds.min[axis]), high = static_cast<float>(bounds.max[axis]);
        note(actions, ImGui::DragFloatRange2(axes[i], &controls.clipMin[i], &controls.clipMax[i],
                                             (high - low) / 400.0F, low, high, "%.4g", nullptr, clamped));
    }
}

void drawClipPlanes(HybridControls& controls, const Bounds& bounds, PanelActions& actions) {
    const auto half = static_cast<float>(0.5 * glm::length(bounds.size()));
    for (std::size_t i = 0; i < controls.clipPlanes.size(); ++i) {
        auto& plane = controls.clipPlanes[i];
        ImGui::PushID(static_cast<int>(i));
        angleSliders("plane", plane.normal, actions);
        const auto middle = static_cast<float>(glm::dot(plane.normal.direction(), bounds.center()));
        note(actions, ImGui::SliderFloat("distance", &plane.distance, middle - half, middle + half, "%.4g"));
        const bool removed = ImGui::Button("Remove plane");
        ImGui::PopID();
        if (!removed) continue;
        controls.clipPlanes.erase(controls.clipPlanes.begin() + static_cast<std::ptrdiff_t>(i));
        actions.viewChanged = true;
        return;
    }
}

void drawClip(HybridControls& controls, const Bounds& bounds, const glm::dvec3& eye, PanelActions& actions) {
    if (!ImGui::CollapsingHeader("Cut away")) return;
    drawClipBox(controls, bounds, actions);
    drawClipPlanes(controls, bounds, actions);
    if (controls.clipPlanes.size() >= HybridStyle::mostClipPlanes) return;
    if (!ImGui::Button("Cut in front of the middle")) return;
    controls.addClipPlane(bounds, eye);
    actions.viewChanged = true;
}

}  // namespace

void drawHybridFacts(const proto::Manifest& manifest, std::uint32_t step, const HybridControls& controls) {
    const auto& hybrid = manifest.hybrid();
    dim(fmt::format("{} {}, {}", fmt::join(hybrid.source_size(), " x "), hybrid.scalar_type(),
                    metric(sourceBytes(hybrid), "B")));
    const auto* shown = stepOf(hybrid, step);
    if (shown == nullptr) return;
    std::string drawn = fmt::format("drawn from {}", fmt::join(hybrid.low_size(), " x "));
    if (drawsPoints(controls, hybrid))
        drawn += fmt::format(" and {}", metric(static_cast<double>(shown->points()), "points"));
    if (drawsResidual(controls, hybrid))
        drawn += fmt::format(" and {}", metric(static_cast<double>(shown->residual_samples()), "residuals"));
    dim(fmt::format("{}; on disk {}", drawn, metric(storedBytes(manifest, *shown), "B")));
    if (hybrid.steps_size() > 1) dim(fmt::format("t = {:.4g}", shown->time()));
}

void drawHybrid(HybridControls& controls, const proto::HybridManifest& manifest, std::uint32_t step,
                const glm::dvec3& eye, PanelActions& actions, float scale) {
    drawCurve(controls, manifest, step, actions, scale);
    drawRepresentation(controls, manifest, actions);
    drawLight(controls, actions);
    drawClip(controls, HybridControls::boundsOf(manifest), eye, actions);
}

}  // namespace mote::client
