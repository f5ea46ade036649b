// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/view_model.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "client/view/apply_edits.h"
#include "client/view/slider_values.h"
#include "protocol/scene/dataset.h"
#include "protocol/scene/view.h"

namespace mote::client {
namespace {

/// A saved view may leave its size to the window.
proto::View sized(proto::View view) {
    if (view.width() == 0) view.set_width(1280);
    if (view.height() == 0) view.set_height(720);
    return view;
}

}  // namespace

ViewModel::ViewModel() {
    message_.add_layers();
    setKind(proto::Layer::kParticles);
}

Status ViewModel::load(const proto::View& view) {
    MOTE_ASSIGN_OR_RETURN(const auto parsed, parseView(sized(view)));
    const bool empty = view.layers().empty();
    auto editor = makeLayerEditor(empty ? proto::Layer::kParticles : view.layers(0).kind_case());
    if (!editor) return Error{ErrorCode::unsupported, "layers[0]", "this viewer cannot edit such a layer"};
    message_ = view;
    loaded_ = true;
    cameraSet_ = view.has_camera();
    camera_ = parsed.camera;
    background = shownColor(view.background(), parsed.background);
    editor_ = std::move(editor);
    if (!empty) editor_->read(layer());
    numbers.read(view);
    before_ = written();
    return success();
}

const proto::Layer& ViewModel::layer() const {
    return message_.layers().empty() ? proto::Layer::default_instance() : message_.layers(0);
}

proto::Layer& ViewModel::mutableLayer() {
    return message_.layers().empty() ? *message_.add_layers() : *message_.mutable_layers(0);
}

proto::View ViewModel::written() const {
    proto::View view = message_;
    assignColor(view.mutable_background(), background);
    view.clear_camera();
    if (cameraSet_) *view.mutable_camera() = toProto(camera_);
    if (!view.layers().empty()) editor_->write(*view.mutable_layers(0));
    numbers.write(view);
    return view;
}

proto::View ViewModel::edited() const {
    proto::View view = message_;
    applyEdits(before_, written(), view);
    return view;
}

void ViewModel::settle() {
    message_ = edited();
    before_ = written();
}

proto::View ViewModel::asked(std::uint32_t width, std::uint32_t height) const {
    proto::View view = edited();
    view.set_width(width);
    view.set_height(height);
    return view;
}

proto::View ViewModel::view(std::uint32_t width, std::uint32_t height) const {
    proto::View view = asked(width, height);
    if (!view.has_camera()) *view.mutable_camera() = toProto(fitted(view));
    return view;
}

proto::View ViewModel::saved(std::uint32_t width, std::uint32_t height) const {
    return loaded_ ? edited() : view(width, height);
}

void ViewModel::setDataset(const std::string& name, const proto::Manifest& manifest) {
    // What no kind of layer draws is asked for as particles, so that the server says why it cannot.
    const auto kinds = layersThatDraw(manifest.kind());
    const bool same = std::find(kinds.begin(), kinds.end(), layer().kind_case()) != kinds.end();
    if (name == dataset() && (same || loaded_)) return describe(manifest);
    settle();
    mutableLayer().set_dataset(name);
    know(name, manifest);
    const bool otherKind = !same && setKind(kinds.empty() ? proto::Layer::kParticles : kinds.front());
    steps_ = stepCount(manifest);
    if (layer().towards().step() >= static_cast<std::uint32_t>(steps_)) mutableLayer().clear_towards();
    setStep(std::min(step(), static_cast<std::uint32_t>(std::max(steps_, 1)) - 1));
    const Bounds before = std::exchange(bounds_, datasetBounds(manifest));
    // They lie in spaces of their own; but a loaded camera is for the first.
    if (otherKind || (std::exchange(described_, true) && bounds_ != before)) fit();
    editor_->setDataset(manifest);
    numbers.setDataset(manifest.particles());
}

std::optional<proto::Towards> ViewModel::towards() const {
    return layer().has_towards() ? std::optional(layer().towards()) : std::nullopt;
}

void ViewModel::setStep(std::uint32_t step) {
    if (step == layer().step()) return;
    mutableLayer().clear_towards();
    mutableLayer().set_step(step);
}

void ViewModel::describe(const proto::Manifest& manifest) {
    settle();
    know(dataset(), manifest);
    steps_ = stepCount(manifest);
    bounds_ = datasetBounds(manifest);
    described_ = true;
    // Read anew, it is as in a view that was just loaded: a dataset brings what that leaves out, and no more.
    if (hasDataset() && parseView(sized(message_)).ok()) editor_->read(layer());
    editor_->setDataset(manifest);
    before_ = written();
}

void ViewModel::know(const std::string& name, const proto::Manifest& manifest) {
    known_[name] = {datasetBounds(manifest), stepCount(manifest), datasetOutlook(manifest)};
}

std::vector<std::string> ViewModel::unknownDatasets() const {
    std::vector<std::string> names;
    for (const auto& each : message_.layers()) {
        if (known_.count(each.dataset()) == 0) names.push_back(each.dataset());
    }
    return names;
}

void ViewModel::drawAs(proto::Layer::KindCase kind, const proto::Manifest& manifest) {
    if (setKind(kind)) editor_->setDataset(manifest);
}

bool ViewModel::setKind(proto::Layer::KindCase kind) {
    if (kind == layer().kind_case()) return false;
    if (editor_) settle();
    editor_ = makeLayerEditor(kind);
    editor_->write(mutableLayer());
    const bool inSteps = kind == proto::Layer::kParticles || kind == proto::Layer::kHybrid;
    if (!inSteps) mutableLayer().clear_towards();
    if (message_.background().empty()) {
        // Drawings have other paper.
        const auto parsed = parseView(sized(message_));
        if (parsed.ok()) background = shownColor(message_.background(), parsed->background);
    }
    before_ = written();
    return true;
}

Camera ViewModel::camera(double aspect) const {
    if (cameraSet_) return camera_;
    constexpr double usualHeight = 720.0;
    const double height = std::clamp(View::maxSide / aspect, 1.0, usualHeight);
    const auto pixels = [](double side) { return static_cast<std::uint32_t>(std::lround(side)); };
    return fitted(asked(std::max(pixels(height * aspect), 1U), pixels(height)));
}

Camera ViewModel::fitted(const proto::View& view) const {
    auto parsed = parseView(view);
    if (!parsed.ok()) return fitCamera(bounds_, static_cast<double>(view.width()) / view.height());
    fitToDatasets(*parsed, known_);
    return parsed->camera;
}

void ViewModel::setCamera(const Camera& camera) {
    camera_ = camera;
    cameraSet_ = true;
}

}  // namespace mote::client
