// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/layer_parts.h"

#include <array>
#include <string_view>
#include <type_traits>
#include <utility>

#include "protocol/scene/fields/resolve.h"
#include "protocol/scene/style_kinds.h"

namespace mote {
namespace {

Status checkKind(const proto::Layer& message) {
    const std::array<std::pair<std::string_view, bool>, 4> parts{{{"colorBy", message.has_color_by()},
                                                                  {"select", message.has_select()},
                                                                  {"highlight", message.has_highlight()},
                                                                  {"paths", message.has_paths()}}};
    for (const auto& [field, there] : parts) {
        if (there && !message.has_particles())
            return Error{ErrorCode::invalidArgument, std::string(field),
                         "only layers of \"particles\" have it"};
    }
    if (message.has_towards() && !message.has_particles() && !message.has_hybrid())
        return Error{ErrorCode::invalidArgument, "towards",
                     "only layers of \"particles\" and \"hybrid\" have it"};
    return success();
}

Result<Towards> parseTowards(const proto::Towards& message) {
    MOTE_RETURN_IF_ERROR(checkFields(message));
    return Towards{message.step(), message.share()};
}

/// Sets an optional part where the message has it.
template <class Part, class Parsed>
Status take(Parsed&& parsed, std::string_view field, std::optional<Part>& part) {
    if (!parsed.ok()) return parsed.error().within(field);
    part = *std::forward<Parsed>(parsed);
    return success();
}

template <class Part>
void visitPart(std::optional<Part>& part, const std::optional<Part>& other, FieldVisitor& visitor) {
    visitor.word(part.has_value() == other.has_value());
    if (part && other) visitFields(*part, *other, visitor);
}

/// What goes nowhere is at the beginning of any way from its step.
void visitTowards(Layer& layer, const Layer& other, FieldVisitor& visitor) {
    if (!layer.towards && !other.towards) return;
    Towards from = layer.towards ? *layer.towards : Towards{other.towards->step, 0.0};
    const Towards to = other.towards ? *other.towards : Towards{from.step, 0.0};
    const bool oneWay = layer.step == other.step && from.step == to.step;
    visitor.word(oneWay);
    if (!oneWay) return;
    visitor.number(from.share, to.share);
    layer.towards = from;
}

}  // namespace

Status parseLayerParts(const proto::Layer& message, const NamedSelectionMessages& named, Layer& layer) {
    MOTE_RETURN_IF_ERROR(checkKind(message));
    if (message.has_color_by())
        MOTE_RETURN_IF_ERROR(take(parseColorBy(message.color_by()), "colorBy", layer.colorBy));
    if (message.has_select())
        MOTE_RETURN_IF_ERROR(take(parseSelection(message.select(), named), "select", layer.select));
    if (message.has_highlight())
        MOTE_RETURN_IF_ERROR(take(parseHighlight(message.highlight(), named), "highlight", layer.highlight));
    if (message.has_paths()) MOTE_RETURN_IF_ERROR(take(parsePaths(message.paths()), "paths", layer.paths));
    if (message.has_towards())
        MOTE_RETURN_IF_ERROR(take(parseTowards(message.towards()), "towards", layer.towards));
    return success();
}

void writeLayerParts(const Layer& layer, proto::Layer& message) {
    if (layer.colorBy) *message.mutable_color_by() = toProto(*layer.colorBy);
    if (layer.select) *message.mutable_select() = toProto(*layer.select);
    if (layer.highlight) *message.mutable_highlight() = toProto(*layer.highlight);
    if (layer.paths) *message.mutable_paths() = toProto(*layer.paths);
    if (!layer.towards) return;
    message.mutable_towards()->set_step(layer.towards->step);
    message.mutable_towards()->set_share(layer.towards->share);
}

void visitLayer(Layer& layer, const Layer& other, FieldVisitor& visitor) {
    std::visit(
        [&](auto& style) {
            visitFields(style, std::get<std::decay_t<decltype(style)>>(other.style), visitor);
        },
        layer.style);
    visitPart(layer.colorBy, other.colorBy, visitor);
    visitor.word(layer.select == other.select);
    visitPart(layer.highlight, other.highlight, visitor);
    visitPart(layer.paths, other.paths, visitor);
    visitTowards(layer, other, visitor);
}

std::size_t valueCount(const Layer& layer) {
    return (layer.select ? valueCount(*layer.select) : 0) +
           (layer.highlight ? valueCount(layer.highlight->selection) : 0);
}

}  // namespace mote
