// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/view_message.h"

#include <fmt/format.h>

#include <algorithm>

#include "protocol/scene/layer_parts.h"
#include "protocol/scene/style_kinds.h"
#include "protocol/scene/transform.h"
#include "protocol/scene/write_fields.h"

namespace mote {
namespace {

void writeLayer(const Layer& layer, const glm::dvec3& background, proto::Layer& message) {
    message.set_dataset(layer.dataset);
    message.set_step(layer.step);
    writeTransform(layer.transform, message.mutable_transform());
    if (layer.opacity != 1.0) message.set_opacity(layer.opacity);
    std::visit([&](const auto& style) { writeStyle(style, background, message); }, layer.style);
    writeLayerParts(layer, message);
}

}  // namespace

proto::View toProto(const View& view) {
    proto::View message;
    message.set_width(view.width);
    message.set_height(view.height);
    if (view.scale != 1.0) message.set_scale(view.scale);
    const auto background = writeColor(view.background, message.mutable_background());
    if (!view.cameraFitted) *message.mutable_camera() = toProto(view.camera);
    for (const auto& layer : view.layers) writeLayer(layer, background, *message.add_layers());
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

}  // namespace mote
