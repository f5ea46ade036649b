// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/view_message.h"

#include <fmt/format.h>

#include <algorithm>
#include <type_traits>

#include "protocol/scene/style_kinds.h"
#include "protocol/scene/write_fields.h"

namespace mote {
namespace {

void writeLayer(const Layer& layer, const glm::dvec3& background, proto::Layer& message) {
    message.set_dataset(layer.dataset);
    message.set_step(layer.step);
    if (layer.transform != glm::dmat4(1.0)) {
        for (int i = 0; i < 16; ++i)
            message.add_transform(layer.transform[i % 4][i / 4]);  // glm keeps columns
    }
    if (layer.opacity != 1.0) message.set_opacity(layer.opacity);
    std::visit([&](const auto& style) { writeStyle(style, background, message); }, layer.style);
}

/// Makes lengths in pixels longer.
class Magnifier : public FieldVisitor {
  public:
    explicit Magnifier(double times) : times_(times) {}
    void between(const std::function<void(double)>&) override {}
    void pixels(double& value, double) override { value *= times_; }
    void word(bool) override {}

  private:
    double times_;
};

}  // namespace

proto::View toProto(const View& view) {
    proto::View message;
    message.set_width(view.width);
    message.set_height(view.height);
    const auto background = writeColor(view.background, message.mutable_background());
    if (!view.cameraFitted) *message.mutable_camera() = toProto(view.camera);
    for (const auto& layer : view.layers) writeLayer(layer, background, *message.add_layers());
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
    Magnifier magnifier(times);
    for (auto& layer : result.layers) {
        std::visit([&](auto& style) { visitFields(style, std::decay_t<decltype(style)>(style), magnifier); },
                   layer.style);
    }
    const auto checked = parseView(toProto(result));
    if (checked.ok()) return result;
    return Error{checked.error().code, checked.error().where,
                 fmt::format("{}; the picture is made {} times as large on each side",
                             checked.error().message, times)};
}

}  // namespace mote
