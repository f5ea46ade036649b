// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/view_model.h"

#include <algorithm>
#include <utility>

#include "protocol/scene/particles_style.h"
#include "protocol/scene/srgb.h"
#include "protocol/scene/view.h"

namespace mote::client {
namespace {

std::array<float, 3> toFloats(const glm::dvec3& color) {
    return {static_cast<float>(color.x), static_cast<float>(color.y), static_cast<float>(color.z)};
}

/// In layer space: of a mesh or a volume its own units, of a plot its box.
Bounds boundsOf(const proto::Manifest& manifest) {
    if (manifest.has_hybrid()) return HybridControls::boundsOf(manifest.hybrid());
    const auto& mesh = manifest.mesh();
    if (mesh.bounds_min_size() != 3 || mesh.bounds_max_size() != 3) return plotBounds;
    return {{mesh.bounds_min(0), mesh.bounds_min(1), mesh.bounds_min(2)},
            {mesh.bounds_max(0), mesh.bounds_max(1), mesh.bounds_max(2)}};
}

void assign(google::protobuf::RepeatedField<double>* field, const std::array<float, 3>& color) {
    field->Clear();
    // Sliders may be a rounding error outside.
    for (const float value : color) field->Add(std::clamp(static_cast<double>(value), 0.0, 1.0));
}

}  // namespace

int stepCount(const proto::Manifest& manifest) {
    return manifest.has_hybrid() ? manifest.hybrid().steps_size() : manifest.particles().steps_size();
}

ViewModel::ViewModel() {
    base_.add_layers()->mutable_particles();
    readStyle();
    plotOpacity_ = pointOpacity;
}

void ViewModel::readStyle() {
    hybrid.read(layer().hybrid());
    stipple.read(layer().stipple());
    const auto style = parseParticlesStyle(layer().particles()).value();
    functions.read(layer().particles());
    colorMap = style.colorMap.name();
    pointOpacity =
        static_cast<float>(layer().particles().points().has_opacity() ? layer().particles().points().opacity()
                                                                      : style.pointOpacity);
    pointSize = static_cast<float>(style.pointSize);
    pointColor = toFloats(linearToSrgb(style.pointColor));
}

Status ViewModel::load(const proto::View& view) {
    proto::View sized = view;
    if (sized.width() == 0) sized.set_width(1280);  // a saved view may leave the size to the window
    if (sized.height() == 0) sized.set_height(720);
    const auto parsed = parseView(sized);
    MOTE_RETURN_IF_ERROR(parsed);
    if (view.layers().empty()) return Error{ErrorCode::invalidArgument, "layers", "the view shows nothing"};
    base_ = view;
    cameraSet_ = view.has_camera();
    camera_ = parsed->camera;
    background = toFloats(linearToSrgb(parsed->background));
    readStyle();
    return success();
}

proto::View ViewModel::view(std::uint32_t width, std::uint32_t height) const {
    proto::View view = base_;
    view.set_width(width);
    view.set_height(height);
    assign(view.mutable_background(), background);
    *view.mutable_camera() = toProto(camera(static_cast<double>(width) / std::max(height, 1U)));
    if (stipples()) {
        stipple.write(*view.mutable_layers(0)->mutable_stipple());
    } else if (showsVolume()) {
        hybrid.write(*view.mutable_layers(0)->mutable_hybrid());
    } else {
        writeParticles(*view.mutable_layers(0)->mutable_particles());
    }
    return view;
}

void ViewModel::writeParticles(proto::ParticlesStyle& style) const {
    functions.write(style);
    style.mutable_volume()->set_color_map(colorMap);
    style.mutable_points()->set_opacity(std::clamp(pointOpacity, 0.0F, 1.0F));
    style.mutable_points()->set_size_pixels(std::clamp(pointSize, 0.1F, 64.0F));
    assign(style.mutable_points()->mutable_color(), pointColor);
}

void ViewModel::setDataset(const std::string& name, const proto::Manifest& manifest) {
    mutableLayer().set_dataset(name);
    const auto steps = static_cast<std::uint32_t>(stepCount(manifest));
    setStep(std::min(step(), steps == 0 ? 0 : steps - 1));
    const Bounds before = std::exchange(bounds_, boundsOf(manifest));
    followPlot(manifest);
    // They lie in spaces of their own; but a loaded camera is for the first.
    if (setKind(manifest.kind()) || (std::exchange(described_, true) && bounds_ != before)) fit();
    if (showsVolume()) hybrid.setDataset(manifest.hybrid());
}

bool ViewModel::setKind(const std::string& kind) {
    if ((kind == "stipple") == stipples() && (kind == "hybrid") == showsVolume()) return false;
    if (kind == "stipple") {
        mutableLayer().mutable_stipple();
    } else if (kind == "hybrid") {
        mutableLayer().mutable_hybrid();
    } else {
        mutableLayer().mutable_particles();
    }
    readStyle();
    return true;
}

/// The opacity of points that nobody has chosen goes with how many the plot has.
void ViewModel::followPlot(const proto::Manifest& manifest) {
    std::uint64_t most = 0;
    for (const auto& each : manifest.particles().steps()) most = std::max(most, each.particles());
    const auto opacity = static_cast<float>(defaultPointOpacity(most));
    const bool chosen = layer().particles().points().has_opacity() || pointOpacity != plotOpacity_;
    if (!chosen) pointOpacity = opacity;
    plotOpacity_ = opacity;
}

Camera ViewModel::camera(double aspect) const {
    return cameraSet_ ? camera_ : fitCamera(bounds_, aspect);
}

void ViewModel::setCamera(const Camera& camera) {
    camera_ = camera;
    cameraSet_ = true;
}

}  // namespace mote::client
