// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/view_message.h"

#include <fmt/format.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <optional>
#include <string>

#include "protocol/base/mote_check.h"
#include "protocol/scene/field_visitor.h"
#include "protocol/scene/layer_parts.h"
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
    if (view.metres && !view.metres->placed) {
        message.set_space("metres");
        if (view.metres->stretch != glm::dvec3(1.0))
            writeVector(view.metres->stretch, message.mutable_stretch());
    }
    if (view.depthContrast != 0.0) message.set_depth_contrast(view.depthContrast);
    if (!view.cameraFitted) *message.mutable_camera() = toProto(view.camera);
    for (const auto& layer : view.layers) writeLayer(layer, *message.add_layers());
    if (view.annotations) *message.mutable_annotations() = *view.annotations;
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
    for (auto& layer : view.layers) {
        const auto* const dots = layer.stipple();
        const bool picture = dots != nullptr && onPlane(*dots);
        const bool spaced = picture && dots->has_spacing_pixels(), sized = picture && dots->has_dot_pixels();
        visitLayer(layer, layer, resolver);
        if (!picture) continue;
        auto& style = std::get<StippleStyle>(layer.style);
        if (!sized) style.set_dot_pixels(pictureDot * std::max(1.0, view.height / pictureLines));
        if (!spaced) style.set_spacing_pixels(std::max(0.5, solidSpacing * style.dot_pixels()));
    }
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

bool hasAxes(const Layer& layer) {
    return isFitted(layer) && layer.particles() != nullptr;
}

bool mayHaveBar(const Layer& layer) {
    return isFitted(layer) && (layer.particles() != nullptr || layer.hybrid() != nullptr);
}

}  // namespace

glm::dvec2 fitMargin(const View& view) {
    constexpr double beside = 4.5, below = 3.6, bar = 7.5, most = 0.3;  // em; of the picture
    glm::dvec2 margin(CameraFit::usualMargin);
    if (!view.annotations) return margin;
    const double em = fontPixels(*view.annotations, view.width, view.height, view.scale);
    const glm::dvec2 inPicture(em / view.width, em / view.height);
    const auto& layers = view.layers;
    if (view.annotations->axes() && std::any_of(layers.begin(), layers.end(), hasAxes))
        margin = glm::max(margin, glm::dvec2(beside, below) * inPicture);
    if (view.annotations->color_bar() && std::any_of(layers.begin(), layers.end(), mayHaveBar))
        margin.x = std::max(margin.x, bar * inPicture.x);
    return glm::min(margin, glm::dvec2(most));
}

double fittedAspect(const View& view) {
    const glm::dvec2 within = 1.0 - 2.0 * fitMargin(view);
    return view.aspect() * within.x / within.y;
}

Outlook outlookOf(const std::optional<Outlook>& own, const glm::dmat4& transform) {
    if (!own) return {};
    const glm::dmat3 linear(transform);
    const Outlook made{linear * own->back, linear * own->up};
    const double sine = glm::length(glm::cross(glm::normalize(made.back), glm::normalize(made.up)));
    return sine > 1e-3 ? made : Outlook{};
}

bool isFitted(const Layer& layer) {
    return !layer.onScreen() && layer.opacity > 0.0;
}

void fitLayers(View& view, std::span<const std::optional<LayerBox>> boxes) {
    MOTE_CHECK(boxes.size() == view.layers.size());
    if (!view.cameraFitted) return;
    std::optional<Bounds> all;
    Outlook outlook;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        if (!boxes[i] || !isFitted(view.layers[i])) continue;
        const auto& transform = view.layers[i].transform;
        if (!all) outlook = outlookOf(boxes[i]->outlook, transform);
        const Bounds inWorld = boxes[i]->box.transformed(transform);
        all = all ? all->united(inWorld) : inWorld;
    }
    if (all) view.camera = fitCamera(*all, fittedAspect(view), outlook, fitMargin(view).y);
}

}  // namespace mote
