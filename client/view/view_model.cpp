// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/view_model.h"

#include <algorithm>
#include <utility>

#include "client/view/slider_values.h"
#include "protocol/scene/dataset.h"
#include "protocol/scene/srgb.h"
#include "protocol/scene/view.h"

namespace mote::client {

ViewModel::ViewModel() {
    base_.add_layers();
    setKind(proto::Layer::kParticles);
}

Status ViewModel::load(const proto::View& view) {
    proto::View sized = view;
    if (sized.width() == 0) sized.set_width(1280);  // a saved view may leave the size to the window
    if (sized.height() == 0) sized.set_height(720);
    MOTE_ASSIGN_OR_RETURN(const auto parsed, parseView(sized));
    if (view.layers().empty()) return Error{ErrorCode::invalidArgument, "layers", "the view shows nothing"};
    auto editor = makeLayerEditor(view.layers(0).kind_case());
    if (!editor) return Error{ErrorCode::unsupported, "layers[0]", "this viewer cannot edit such a layer"};
    base_ = view;
    cameraSet_ = view.has_camera();
    camera_ = parsed.camera;
    background = toFloats(linearToSrgb(parsed.background));
    editor_ = std::move(editor);
    editor_->read(layer());
    numbers.read(view);
    return success();
}

proto::View ViewModel::view(std::uint32_t width, std::uint32_t height) const {
    proto::View view = base_;
    view.set_width(width);
    view.set_height(height);
    assignColor(view.mutable_background(), background);
    *view.mutable_camera() = toProto(camera(static_cast<double>(width) / std::max(height, 1U)));
    editor_->write(*view.mutable_layers(0));
    numbers.write(view);
    return view;
}

void ViewModel::setDataset(const std::string& name, const proto::Manifest& manifest) {
    mutableLayer().set_dataset(name);
    // What no kind of layer draws is asked for as particles, so that the server says why it cannot.
    const auto kinds = layersThatDraw(manifest.kind());
    const bool same = std::find(kinds.begin(), kinds.end(), layer().kind_case()) != kinds.end();
    const bool otherKind = !same && setKind(kinds.empty() ? proto::Layer::kParticles : kinds.front());
    steps_ = stepCount(manifest);
    setStep(std::min(step(), static_cast<std::uint32_t>(std::max(steps_, 1)) - 1));
    const Bounds before = std::exchange(bounds_, datasetBounds(manifest));
    // They lie in spaces of their own; but a loaded camera is for the first.
    if (otherKind || (std::exchange(described_, true) && bounds_ != before)) fit();
    editor_->setDataset(manifest);
    numbers.setDataset(manifest.particles());
}

void ViewModel::describe(const proto::Manifest& manifest) {
    steps_ = stepCount(manifest);
    bounds_ = datasetBounds(manifest);
    described_ = true;
    editor_->setDataset(manifest);
}

void ViewModel::drawAs(proto::Layer::KindCase kind, const proto::Manifest& manifest) {
    if (setKind(kind)) editor_->setDataset(manifest);
}

bool ViewModel::setKind(proto::Layer::KindCase kind) {
    if (kind == layer().kind_case()) return false;
    editor_ = makeLayerEditor(kind);
    editor_->write(mutableLayer());
    return true;
}

Camera ViewModel::camera(double aspect) const {
    return cameraSet_ ? camera_ : fitCamera(bounds_, aspect);
}

void ViewModel::setCamera(const Camera& camera) {
    camera_ = camera;
    cameraSet_ = true;
}

}  // namespace mote::client
