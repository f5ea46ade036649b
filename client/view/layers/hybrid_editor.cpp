// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/layers/hybrid_editor.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <imgui.h>

#include <algorithm>
#include <cstdlib>
#include <glm/common.hpp>
#include <utility>

#include "client/view/layers/field_controls.h"
#include "client/view/panel_widgets.h"
#include "client/view/server_state.h"
#include "protocol/scene/color_map.h"
#include "protocol/scene/dataset.h"
#include "protocol/scene/fields/resolve.h"
#include "protocol/scene/hybrid_style.h"
#include "protocol/scene/write_fields.h"

namespace mote::client {
namespace {

Interval valuesOf(const proto::HybridManifest& manifest) {
    const double low = manifest.value_min(), high = manifest.value_max();
    return {low, high > low ? high : low + 1.0};
}

std::span<const std::uint64_t> histogramOf(const proto::HybridManifest& manifest) {
    if (manifest.steps().empty()) return {};
    const auto& bins = manifest.steps(0).histogram();
    return {bins.data(), static_cast<std::size_t>(bins.size())};
}

void writeCurve(const KnotCurve& curve, proto::HybridStyle& style) {
    style.clear_curve();
    for (std::size_t i = 0; i < curve.knots().size(); ++i) {
        auto& written = *style.add_curve();
        written.set_value(curve.knots()[i].x);
        written.set_opacity(curve.knots()[i].y);
        if (!curve.colors().empty()) assignColor(written.mutable_color(), curve.colors()[i]);
    }
}

void readCurve(const proto::HybridStyle& style, KnotCurve& curve) {
    std::vector<Curve::Knot> knots;
    std::vector<KnotCurve::Color> colors;
    for (const auto& knot : style.curve()) {
        knots.push_back({knot.value(), knot.opacity()});
        if (knot.color_size() == 3) colors.push_back(toFloats({knot.color(0), knot.color(1), knot.color(2)}));
    }
    curve.take(std::move(knots), std::move(colors));
}

/// With what is left out.
proto::HybridStyle shownOf(const proto::HybridStyle& said) {
    return parseHybridStyle(said).value();
}

constexpr const char* bestName = "best";  // for the empty name

const proto::HybridStepEntry* stepOf(const proto::HybridManifest& manifest, std::uint32_t step) {
    const bool there = step < static_cast<std::uint32_t>(manifest.steps_size());
    return there ? &manifest.steps(static_cast<int>(step)) : nullptr;
}

/// Chooses as render::hybridParts does.
bool drawsResidual(const HybridControls& controls, const proto::HybridManifest& manifest) {
    const auto& asked = controls.rest.representation();
    return manifest.residual() && (asked.empty() || asked == "residual");
}

bool drawsPoints(const HybridControls& controls, const proto::HybridManifest& manifest) {
    const auto& asked = controls.rest.representation();
    return manifest.point_bytes() > 0 && (asked == "points" || (asked.empty() && !manifest.residual()));
}

/// "i16" has 16 bits.
double sourceBytes(const proto::HybridManifest& manifest) {
    const auto& type = manifest.scalar_type();
    double bytes = type.empty() ? 0.0 : std::atof(&type[1]) / 8.0;
    for (const auto side : manifest.source_size()) bytes *= side;
    return bytes;
}

/// What one step takes.
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
        controls.curve.take(preset.knots, preset.colors);
        actions.viewChanged = true;
    }
    ImGui::EndCombo();
}

/// The colours are a colour map's, or each knot has one: the knot's that was last taken hold of is shown.
void drawColors(HybridControls& controls, PanelActions& actions) {
    if (auto* color = controls.curve.chosenColor()) {
        colorBox(actions, "knot's colour", *color);
        ImGui::SameLine();
        if (ImGui::Button("Use a colour map")) {
            controls.curve.dropColors();
            actions.viewChanged = true;
        }
        return;
    }
    const std::string map = controls.colorMap;
    colorMapList(actions, "colours", controls.colorMap);
    controls.ownMap = controls.ownMap || controls.colorMap != map;
    checkbox(actions, "own range of colours", controls.ownColorRange);
    auto& range = controls.colorRange;
    if (controls.ownColorRange) rangeBox(actions, "range", range[0], range[1], controls.curve.axis(), 500.0);
}

void drawCurve(HybridControls& controls, const proto::HybridManifest& manifest, const LayerPanel& panel) {
    if (!section("Transfer function")) return;
    const std::string unit = manifest.value_unit().empty() ? "value" : manifest.value_unit();
    CurveEditorLook look{
        .xName = unit.c_str(), .yName = "opacity", .rootAxis = true, .height = 150.0F * panel.scale};
    look.axis = controls.curve.axis();
    look.histogramRange = {manifest.value_min(), manifest.value_max()};
    if (const auto* shown = stepOf(manifest, panel.step)) {
        look.histogram = {shown->histogram().data(), static_cast<std::size_t>(shown->histogram_size())};
    }
    look.color = [&](double value) { return controls.color(value); };
    text(fmt::format("opacity over {}", manifest.value_unit().empty() ? "values" : manifest.value_unit()));
    const auto before = controls.curve.extent();
    const auto knots = controls.curve.knots().size();
    noteCurve(panel.actions, curveEditor("curve", controls.curve, look));
    if (controls.curve.knots().size() > knots) controls.keepColors(before);
    dim(fmt::format("{:.5g} to {:.5g}", look.axis.low, look.axis.high));
    drawPresets(controls, manifest, panel.actions);
    drawColors(controls, panel.actions);
}

void drawRepresentation(HybridControls& controls, const proto::HybridManifest& manifest,
                        PanelActions& actions) {
    if (!section("Representation")) return;
    std::vector<std::string_view> names{bestName, "volume"};
    if (manifest.point_bytes() > 0) names.emplace_back("points");
    if (manifest.residual()) names.emplace_back("residual");
    auto& style = controls.rest;
    std::string chosen = style.representation().empty() ? bestName : style.representation();
    nameList(actions, "drawn", chosen, names);
    style.set_representation(chosen == bestName ? "" : chosen);
    if (!drawsPoints(controls, manifest)) return;
    fieldControls(actions, style, shownOf(style),
                  [](std::string_view name) { return name.starts_with("point"); });
}

void drawLight(HybridControls& controls, PanelActions& actions) {
    if (!section("Light")) return;
    auto& style = controls.rest;
    fieldControls(actions, style, shownOf(style), [](std::string_view name) {
        return name.starts_with("light") && name != "light.shadow";  // volumes cast none
    });
}

}  // namespace

HybridControls::HybridControls() {
    read(shownOf({}));
}

std::vector<CurvePreset> HybridControls::presets(const proto::HybridManifest& manifest) {
    const Interval values = valuesOf(manifest);
    return presetsOf(manifest.value_unit(), {values.low, values.high}, histogramOf(manifest));
}

void HybridControls::setDataset(const proto::HybridManifest& manifest) {
    const Interval values = valuesOf(manifest);
    const bool first = values_ == Interval{0.0, 0.0};
    const bool same = manifest.value_unit() == valuesUnit_ && values == values_;
    values_ = values;
    valuesUnit_ = manifest.value_unit();
    highest_ = highestShown(histogramOf(manifest), {values.low, values.high});
    curve.setValues(values);
    if (same) return;
    if (!first) ownCurve_ = ownMap = ownColorRange = false;
    takeUnsaid(manifest);
}

void HybridControls::takeUnsaid(const proto::HybridManifest& manifest) {
    if (!ownCurve_) {
        const auto preset = presets(manifest).front();
        curve.take(preset.knots, ownMap ? std::vector<KnotCurve::Color>() : preset.colors);
    }
    if (!ownColorRange) colorRange = {values_.low, values_.high};
}

Interval HybridControls::mapOver(const Interval& extent) const {
    const double high = rest.shows() == "maximum" ? std::max(extent.high, highest_) : extent.high;
    if (ownMap) return {extent.low, high};
    const ValueRange readable = readableColors({extent.low, high});
    return {readable.low, readable.high};
}

glm::dvec3 HybridControls::color(double value) const {
    if (!curve.colors().empty()) return curve.color(value);
    const auto map = ColorMap::find(colorMap);
    const Interval ends = ownColorRange ? Interval{colorRange[0], colorRange[1]} : mapOver(curve.extent());
    return map.ok() ? (*map)((value - ends.low) / (ends.high - ends.low)) : glm::dvec3(0.0);
}

void HybridControls::keepColors(const Interval& extent) {
    if (!curve.colors().empty() || ownColorRange || extent == curve.extent()) return;
    const Interval range = mapOver(extent);
    ownColorRange = true;
    colorRange = {range.low, range.high};
}

void HybridControls::write(proto::HybridStyle& style) const {
    style = rest;
    writeCurve(curve, style);
    if (curve.colors().empty()) {
        if (ownMap) style.set_color_map(colorMap);
        if (ownColorRange && colorRange[0] < colorRange[1]) {
            for (const double end : colorRange) style.add_color_range(end);
        }
    }
}

void HybridControls::read(const proto::HybridStyle& message) {
    const auto style = hybridStyleOf(parseHybridStyle(message).value());
    readCurve(message, curve);
    ownCurve_ = !message.curve().empty();
    values_ = {0.0, 0.0};
    ownMap = !message.color_map().empty();
    colorMap = style.colorMap.name();
    ownColorRange = style.colorRange.has_value();
    if (style.colorRange) colorRange = {style.colorRange->low, style.colorRange->high};
    rest = message;
    rest.clear_curve();
    rest.clear_color_map();
    rest.clear_color_range();
}

void HybridEditor::drawFacts(const LayerPanel& panel) {
    const auto& manifest = panel.server.shown->manifest();
    const auto& hybrid = manifest.hybrid();
    dim(fmt::format("{} {}, {}", fmt::join(hybrid.source_size(), " x "), hybrid.scalar_type(),
                    metric(sourceBytes(hybrid), "B")));
    const auto* shown = stepOf(hybrid, panel.step);
    if (shown == nullptr) return;
    std::string drawn = fmt::format("drawn from {}", fmt::join(hybrid.low_size(), " x "));
    if (drawsPoints(controls, hybrid))
        drawn += fmt::format(" and {}", metric(static_cast<double>(shown->points()), "points"));
    if (drawsResidual(controls, hybrid))
        drawn += fmt::format(" and {}", metric(static_cast<double>(shown->residual_samples()), "residuals"));
    dim(fmt::format("{}; on disk {}", drawn, metric(storedBytes(manifest, *shown), "B")));
    if (hybrid.steps_size() > 1) dim(fmt::format("t = {:.4g}", shown->time()));
}

void HybridEditor::draw(const LayerPanel& panel) {
    if (!panel.server.shown) return;
    const auto& manifest = panel.server.shown->manifest().hybrid();
    drawCurve(controls, manifest, panel);
    drawRepresentation(controls, manifest, panel.actions);
    drawLight(controls, panel.actions);
    backgroundBox(panel.actions, panel.background);
}

}  // namespace mote::client
