// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/layers/particles_editor.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <span>

#include "client/view/panel_widgets.h"
#include "client/view/server_state.h"
#include "protocol/quantity/plot_axes.h"
#include "protocol/scene/color_map.h"
#include "protocol/scene/particles_style.h"
#include "protocol/scene/srgb.h"

namespace mote::client {
namespace {

using Which = TransferFunctions::Which;

constexpr const char* linearAxis = "linear axis";

/// One of the two curves, for the curve editor.
class DensityCurve final : public EditedCurve {
  public:
    DensityCurve(TransferFunctions& functions, Which which) : functions_(functions), which_(which) {}
    const std::vector<Curve::Knot>& knots() const override { return functions_.knots(which_); }
    void move(std::size_t knot, Curve::Knot to) override { functions_.move(which_, knot, to); }
    std::size_t insert(Curve::Knot at) override { return functions_.insert(which_, at); }
    void remove(std::size_t knot) override { functions_.remove(which_, knot); }

  private:
    TransferFunctions& functions_;
    Which which_;
};

const proto::ParticleStepEntry* shownStep(const LayerPanel& panel) {
    if (!panel.server.shown) return nullptr;
    const auto& steps = panel.server.shown->manifest().particles().steps();
    const bool there = panel.step < static_cast<std::uint32_t>(steps.size());
    return there ? &steps[static_cast<int>(panel.step)] : nullptr;
}

std::span<const std::uint64_t> shownHistogram(const LayerPanel& panel) {
    const auto* step = shownStep(panel);
    if (step == nullptr) return {};
    return {step->density_histogram().data(), static_cast<std::size_t>(step->density_histogram_size())};
}

void volumeHelp(int field) {
    fieldHelp(proto::VolumeStyle::default_instance(), field);
}
void pointsHelp(int field) {
    fieldHelp(proto::PointsStyle::default_instance(), field);
}

void drawPresets(ParticlesControls& controls, PanelActions& actions) {
    if (!ImGui::BeginCombo("preset", "choose curves")) return;
    if (ImGui::Selectable("the plot's own")) {
        controls.take(nullptr);
        actions.viewChanged = true;
    }
    for (const auto& preset : densityPresets()) {
        if (!ImGui::Selectable(std::string(preset.name).c_str())) continue;
        controls.take(&preset);
        actions.viewChanged = true;
    }
    ImGui::EndCombo();
}

/// What curves and colours are told between, so that those of two plots or runs can be the same.
void drawDensities(ParticlesControls& controls, PanelActions& actions) {
    const auto ofPlot = controls.densitiesOfPlot();
    bool own = controls.densities.has_value();
    ImGui::BeginDisabled(!own && !ofPlot);
    if (ImGui::Checkbox("own range of densities", &own)) {
        controls.densities = own ? ofPlot : std::nullopt;
        actions.viewChanged = true;
    }
    volumeHelp(proto::VolumeStyle::kDensityRangeFieldNumber);
    ImGui::EndDisabled();
    if (!controls.densities) return;
    Interval typed = *controls.densities;
    const auto field = [](const char* label, double& value) {
        return ImGui::InputDouble(label, &value, 0.0, 0.0, "%.5g", ImGuiInputTextFlags_EnterReturnsTrue);
    };
    const bool low = field("least density", typed.low), high = field("greatest density", typed.high);
    if (!(low || high) || !(typed.low > 0.0) || !(typed.high > typed.low) || !std::isfinite(typed.high))
        return;
    controls.densities = typed;
    actions.viewChanged = true;
}

/// What is said of a place on the axis of both curves.
std::string densityAt(const Interval& densities, double t) {
    const double density = densities.low * std::pow(densities.high / densities.low, t);
    return fmt::format("log density {:.4g}, density {:.3g}", t, density);
}

/// The axis of densities, which both curves have, and what lies along it.
CurveEditorLook densityLook(const ParticlesControls& controls, const LayerPanel& panel) {
    CurveEditorLook look{.xName = "log density", .yName = "", .rootAxis = false, .height = 0.0F};
    look.histogram = shownHistogram(panel);
    look.lit = panel.server.litDensities;
    const auto ofPlot = controls.densitiesOfPlot();
    if (!ofPlot) return look;
    const auto shown = controls.densities.value_or(*ofPlot);
    const double span = std::log(shown.high / shown.low);
    const auto placeOf = [&](double density) { return std::log(density / shown.low) / span; };
    look.histogramRange = {placeOf(ofPlot->low), placeOf(ofPlot->high)};
    look.said = [shown](double t) { return densityAt(shown, t); };
    if (ImGui::GetStateStorage()->GetBool(ImGui::GetID(linearAxis))) look.bend = span;
    return look;
}

/// Of the axis, for both curves.
void drawAxisChoice(const LayerPanel& panel) {
    bool& linear = *ImGui::GetStateStorage()->GetBoolRef(ImGui::GetID(linearAxis));
    ImGui::SameLine();
    ImGui::Checkbox(linearAxis, &linear);
    helpAtRest("the curves' axis is even in density, not in its logarithm; the picture stays as it is");
    ImGui::SameLine();
    if (ImGui::Button("Light a region")) panel.actions.command = "Densities of a region";
    helpAtRest("drag a rectangle over the picture: the densities in it are lit behind the curves (T)");
}

void drawCurves(ParticlesControls& controls, const LayerPanel& panel) {
    if (!section("Transfer functions")) return;
    drawPresets(controls, panel.actions);
    auto look = densityLook(controls, panel);
    look.yName = "opacity";
    look.rootAxis = true;
    look.height = 120.0F * panel.scale;
    look.color = [drawn = controls.drawn()](double t) { return drawn.color(t); };
    const char* axis = look.bend > 0.0 ? "density" : "log density";
    text(fmt::format("Volume: opacity over {}", axis));
    DensityCurve volume(controls.functions, Which::volume);
    noteCurve(panel.actions, curveEditor("volume", volume, look));
    colorMapList(panel.actions, "colours", controls.colorMap);
    volumeHelp(proto::VolumeStyle::kColorMapFieldNumber);
    text(fmt::format("Points: fraction over {}", axis));
    look.yName = "fraction";
    look.rootAxis = false;
    look.height = 90.0F * panel.scale;
    look.color = {};
    DensityCurve points(controls.functions, Which::points);
    noteCurve(panel.actions, curveEditor("points", points, look));
    bool linked = controls.functions.linked();
    if (ImGui::Checkbox("linked", &linked)) {
        controls.functions.setLinked(linked);
        panel.actions.viewChanged = true;
    }
    pointsHelp(proto::PointsStyle::kLinkedFieldNumber);
    drawAxisChoice(panel);
    drawDensities(controls, panel.actions);
}

void drawPoints(ParticlesControls& controls, const LayerPanel& panel) {
    if (!section("Points")) return;
    logSlider(panel.actions, "opacity", controls.pointOpacity, 0.0005F, 1.0F, "%.4f");
    pointsHelp(proto::PointsStyle::kOpacityFieldNumber);
    logSlider(panel.actions, "size (pixels)", controls.pointSize, 0.3F, 16.0F, "%.1f");
    pointsHelp(proto::PointsStyle::kSizePixelsFieldNumber);
    colorBox(panel.actions, "colour", controls.pointColor);
    pointsHelp(proto::PointsStyle::kColorFieldNumber);
    ImGui::SameLine();
    backgroundBox(panel.actions, panel.background);
}

}  // namespace

ParticlesControls::ParticlesControls() {
    read({});
    plotOpacity_ = pointOpacity;
    plotSize_ = pointSize;
    plotColor_ = pointColor;
}

bool ParticlesControls::opacityChosen() const {
    return ownOpacity_ || pointOpacity != plotOpacity_;
}

bool ParticlesControls::sizeChosen() const {
    return ownSize_ || pointSize != plotSize_;
}

bool ParticlesControls::colorChosen() const {
    return ownColor_ || pointColor != plotColor_;
}

/// What the style is where a view leaves all of it to its plot.
ParticlesStyle ParticlesControls::styleOfPlot() const {
    auto style = particlesStyleOf(parseParticlesStyle({}).value());
    if (plot_) resolveByPlot(style, *plot_);
    return style;
}

void ParticlesControls::take(const DensityPreset* preset) {
    if (preset != nullptr) return functions.take(preset->opacity, preset->fraction);
    functions.leaveToPlot();
    const auto style = styleOfPlot();
    functions.setOfPlot(style.volumeOpacity, style.pointFraction);
}

std::optional<Interval> ParticlesControls::densitiesOfPlot() const {
    if (!plot_ || !(plot_->scale.max > plot_->scale.min)) return std::nullopt;
    return Interval{plot_->scale.min / plot_->span, plot_->scale.max / plot_->span};
}

void ParticlesControls::setDataset(const proto::ParticlesManifest& manifest) {
    plot_ = PlotDensity::of(manifest);
    const auto style = styleOfPlot();
    functions.setOfPlot(style.volumeOpacity, style.pointFraction);
    const bool chosen = colorChosen();
    plotColor_ = toFloats(linearToSrgb(style.pointColor));
    if (!chosen) pointColor = plotColor_;
}

void ParticlesControls::write(proto::ParticlesStyle& style) const {
    functions.write(style);
    auto& volume = *style.mutable_volume();
    volume.set_color_map(colorMap);
    volume.clear_density_range();
    if (densities) {
        volume.add_density_range(densities->low);
        volume.add_density_range(densities->high);
    }
    auto& points = *style.mutable_points();
    points.clear_opacity();
    points.clear_size_pixels();
    if (opacityChosen()) points.set_opacity(share(pointOpacity));
    if (sizeChosen()) points.set_size_pixels(decimal(std::clamp(pointSize, 0.1F, 64.0F)));
    points.clear_color();
    if (colorChosen()) assignColor(points.mutable_color(), pointColor);
}

void ParticlesControls::read(const proto::ParticlesStyle& message) {
    const auto style = particlesStyleOf(parseParticlesStyle(message).value());
    functions.read(message);
    colorMap = style.colorMap.name();
    densities.reset();
    if (style.densityRange) densities = Interval{style.densityRange->low, style.densityRange->high};
    ownOpacity_ = message.points().has_opacity();
    ownSize_ = message.points().has_size_pixels();
    ownColor_ = !message.points().color().empty();
    pointOpacity = static_cast<float>(ownOpacity_ ? message.points().opacity() : style.pointOpacity);
    pointSize = static_cast<float>(style.pointSize);
    pointColor = shownColor(message.points().color(), style.pointColor);
}

TransferFunction ParticlesControls::drawn() const {
    proto::ParticlesStyle message;
    write(message);
    auto parsed = parseParticlesStyle(message);
    if (!parsed.ok()) parsed = parseParticlesStyle({});
    auto style = particlesStyleOf(*parsed);
    if (plot_) resolveByPlot(style, *plot_);
    return style.transfer();
}

void ParticlesEditor::drawFacts(const LayerPanel& panel) {
    const auto& dataset = *panel.server.shown;
    if (const auto* step = shownStep(panel)) {
        dim(fmt::format("{}, {} lost, t = {:.4g} s",
                        metric(static_cast<double>(step->particles()), "particles"), step->lost(),
                        step->time()));
    }
    const auto shown = axesOf(dataset);
    if (!shown) return;
    drawAxisLists(*shown, dataset, panel.actions);
    const auto& plot = dataset.manifest().particles();
    for (int a = 0; a < axesOfPlot; ++a) {
        const auto& axis = axisOf(plot, a, panel.step);
        dim(fmt::format("{}: {:.4g} to {:.4g} {}", axis.name(), axis.min(), axis.max(), axis.unit()));
    }
    if (!dataset.has_replot()) dim("Its run is not beneath the server's roots: no other plots.");
}

void ParticlesEditor::drawAxisLists(const AxisNames& shown, const proto::Description& dataset,
                                    PanelActions& actions) {
    if (axesOfDataset_ != dataset.dataset()) {
        axes_ = shown;
        axesOfDataset_ = dataset.dataset();
    }
    ImGui::PushItemWidth(78.0F * ImGui::GetFontSize() / 14.0F);
    for (std::size_t i = 0; i < axes_.size(); ++i) {
        if (i > 0) ImGui::SameLine();
        chooseName(fmt::format("##axis{}", i).c_str(), axes_[i], plotAxes());
    }
    ImGui::PopItemWidth();
    ImGui::SameLine();
    const bool three = std::set<std::string>(axes_.begin(), axes_.end()).size() == 3;
    ImGui::BeginDisabled(!three || axes_ == shown || !dataset.has_replot());
    if (ImGui::Button("Plot")) actions.plot = axes_;
    ImGui::EndDisabled();
}

void ParticlesEditor::draw(const LayerPanel& panel) {
    drawCurves(controls, panel);
    drawPoints(controls, panel);
}

}  // namespace mote::client
