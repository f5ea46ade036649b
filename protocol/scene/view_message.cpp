// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/view_message.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>

#include "protocol/scene/field_visitor.h"
#include "protocol/scene/layer_parts.h"
#include "protocol/scene/mote_check.h"
#include "protocol/scene/write_fields.h"

namespace mote {
namespace {

void writeLayer(const Layer& layer, proto::Layer& message) {
    message.set_dataset(layer.dataset);
    message.set_step(layer.step);
    writeTransform(layer.transform, message.mutable_transform());
    if (layer.opacity != 1.0) message.set_opacity(layer.opacity);
    std::visit([&](const auto& style) { writeStyle(style, message); }, layer.style);
    writeLayerParts(layer, message);
}

}  // namespace

proto::View toProto(const View& view) {
    proto::View message;
    message.set_width(view.width);
    message.set_height(view.height);
    if (view.scale != 1.0) message.set_scale(view.scale);
    writeColor(view.background, message.mutable_background());
    if (!view.cameraFitted) *message.mutable_camera() = toProto(view.camera);
    for (const auto& layer : view.layers) writeLayer(layer, *message.add_layers());
    if (view.annotations) *message.mutable_annotations() = toProto(*view.annotations);
    for (const auto& [name, selection] : view.selections) {
        auto& added = *message.add_selections();
        added.set_name(name);
        *added.mutable_selection() = toProto(selection);
    }
    return message;
}

Result<View> magnified(const View& view, unsigned times) {
    if (times < 1 || times > View::maxSide) {
        return Error{ErrorCode::invalidArgument, "",
                     fmt::format("a picture is magnified 1 to {} times, not {}", View::maxSide, times)};
    }
    View result = view;
    result.width =
        static_cast<std::uint32_t>(std::min<std::uint64_t>(std::uint64_t{view.width} * times, ~0U));
    result.height =
        static_cast<std::uint32_t>(std::min<std::uint64_t>(std::uint64_t{view.height} * times, ~0U));
    result.scale = view.scale * times;
    const auto checked = parseView(toProto(result));
    if (checked.ok()) return result;
    return Error{checked.error().code, checked.error().where,
                 fmt::format("{}; the picture is made {} times as large on each side",
                             checked.error().message, times)};
}

namespace {

/// Sees lengths alone.
class LengthVisitor : public FieldVisitor {
  public:
    LengthVisitor(std::uint32_t height, double scale) : height_(height), scale_(scale) {}
    void between(const std::function<void(double)>&) override {}
    void word(bool) override {}

  protected:
    std::uint32_t height_;
    double scale_;
};

class Resolver : public LengthVisitor {
  public:
    using FieldVisitor::pixels;
    using LengthVisitor::LengthVisitor;
    void pixels(ScreenLength& value, const ScreenLength&, const LengthField& field) override {
        value = field.inPixels(value, height_, scale_);
    }
};

class Checker : public LengthVisitor {
  public:
    using FieldVisitor::pixels;
    using LengthVisitor::LengthVisitor;
    void pixels(ScreenLength& value, const ScreenLength&, const LengthField& field) override {
        if (error || !value.said() || value * scale_ <= field.greatest) return;
        error = Error{ErrorCode::invalidArgument, std::string(field.path),
                      fmt::format("{} times the view's scale of {} is more than {} pixels", value.value(),
                                  scale_, field.greatest)};
    }

    std::optional<Error> error;
};

}  // namespace

View lengthsInPixels(View view) {
    Resolver resolver(view.height, view.scale);
    for (auto& layer : view.layers) visitLayer(layer, layer, resolver);
    if (view.annotations) view.annotations = inPixels(*view.annotations, view.width, view.height, view.scale);
    view.scale = 1.0;
    return view;
}

Status checkLengths(const View& view) {
    if (view.scale <= 1.0) return success();
    for (std::size_t i = 0; i < view.layers.size(); ++i) {
        Checker checker(view.height, view.scale);
        Layer layer = view.layers[i];
        visitLayer(layer, layer, checker);
        if (checker.error) return checker.error->within(fmt::format("layers[{}]", i));
    }
    return success();
}

namespace {

/// What of a picture stays free for the labels of axes, on each side.
double marginOf(const View& view) {
    constexpr double labels = 4.5, most = 0.25;  // em; of the picture's shorter side
    if (!view.annotations || !view.annotations->axes) return 0.0;
    const double side = std::min(view.width, view.height);
    return std::min(most, labels * view.annotations->fontPixels(view.width, view.height, view.scale) / side);
}

Bounds grown(const Bounds& bounds, double factor) {
    const glm::dvec3 half = 0.5 * factor * bounds.size();
    return {bounds.center() - half, bounds.center() + half};
}

}  // namespace

bool isFitted(const Layer& layer) {
    const bool onScreen = layer.stipple() != nullptr && onPlane(*layer.stipple());
    return !onScreen && layer.opacity > 0.0;
}

void fitLayers(View& view, std::span<const std::optional<Bounds>> boxes) {
    MOTE_CHECK(boxes.size() == view.layers.size());
    if (!view.cameraFitted) return;
    std::optional<Bounds> all;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        if (!boxes[i] || !isFitted(view.layers[i])) continue;
        const Bounds inWorld = boxes[i]->transformed(view.layers[i].transform);
        all = all ? all->united(inWorld) : inWorld;
    }
    if (all) view.camera = fitCamera(grown(*all, 1.0 / (1.0 - 2.0 * marginOf(view))), view.aspect());
}

}  // namespace mote
