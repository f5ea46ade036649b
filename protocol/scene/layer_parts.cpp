// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/layer_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <type_traits>
#include <utility>

#include "protocol/quantity/quantity.h"
#include "protocol/scene/field_visitor.h"
#include "protocol/scene/fields/facts.h"
#include "protocol/scene/fields/resolve.h"
#include "protocol/scene/particles_style.h"
#include "protocol/scene/view.h"
#include "protocol/scene/write_fields.h"

namespace mote {

Result<proto::ColorBy> parseColorBy(proto::ColorBy message) {
    MOTE_ASSIGN_OR_RETURN(*message.mutable_column(), checkColumnName(message.column(), "column"));
    MOTE_ASSIGN_OR_RETURN(auto colorBy, resolved(std::move(message)));
    const auto range = colorRangeOf(colorBy);
    if (range && !(range->low < range->high))
        return invalid("range", "the second value must be the greater one");
    return colorBy;
}

std::optional<ValueRange> colorRangeOf(const proto::ColorBy& colorBy) {
    if (colorBy.range().empty()) return std::nullopt;
    return ValueRange{colorBy.range(0), colorBy.range(1)};
}

ColorMap colorMapOf(const proto::ColorBy& colorBy) {
    return ColorMap::find(colorBy.color_map()).value();
}

bool colorsOfNearest(const proto::ColorBy& colorBy, const ParticlesStyle& style) {
    constexpr double opaque = 0.5;  // points of such an opacity hide those behind them
    if (!colorBy.of_pixel().empty()) return colorBy.of_pixel() == "nearest";
    return !style.opacityByPlot && style.pointOpacity >= opaque;
}

Result<proto::Paths> parsePaths(proto::Paths message) {
    auto& ids = *message.mutable_ids();
    if (ids.size() > mostPathIds)
        return invalid("ids", fmt::format("there may be at most {}, not {}", mostPathIds, ids.size()));
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
    return resolved(std::move(message));
}

Result<Highlight> parseHighlight(const proto::Highlight& message, const NamedSelectionMessages& named) {
    Highlight highlight;
    if (!message.has_selection())
        return Error{ErrorCode::invalidArgument, "selection", "what is to be highlighted is missing"};
    auto selection = parseSelection(message.selection(), named);
    MOTE_RETURN_IF_ERROR(selection, "selection");
    highlight.selection = *std::move(selection);
    MOTE_RETURN_IF_ERROR(checkOwnFields(message));
    highlight.color = colorOf(message, message.kColorFieldNumber).value();
    if (message.has_size_pixels()) highlight.pointSize = message.size_pixels();
    highlight.opacity =
        std::min(numberOf(message, message.kOpacityFieldNumber), ParticlesStyle::opacityLimit);
    return highlight;
}

proto::Highlight toProto(const Highlight& highlight) {
    proto::Highlight message;
    *message.mutable_selection() = toProto(highlight.selection);
    writeColor(highlight.color, message.mutable_color());
    if (highlight.pointSize) message.set_size_pixels(*highlight.pointSize);
    message.set_opacity(highlight.opacity);
    return message;
}

void visitFields(Highlight& highlight, const Highlight& other, FieldVisitor& visitor) {
    visitor.word(highlight.selection == other.selection);
    visitor.vector(highlight.color, other.color);
    visitor.number(highlight.opacity, other.opacity);
    visitor.word(highlight.pointSize.has_value() == other.pointSize.has_value());
    if (highlight.pointSize && other.pointSize)
        visitor.pixels(*highlight.pointSize, *other.pointSize, lengthField("highlight.sizePixels"));
}

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
    if (message.has_image() && message.transform_size() > 0)
        return invalid("transform", "an image lies on the screen: it fills the view and has no other place");
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

/// A device knows so many half-spaces.
Status checkClips(const Layer& layer) {
    const auto* const style = layer.hybrid();
    if (style == nullptr) return success();
    if (layer.clip->planes_size() + style->clip_planes_size() > mostClipPlanes) {
        return invalid("clip.planes",
                       fmt::format("a layer has at most {} clip planes, those of \"hybrid\" among them",
                                   mostClipPlanes));
    }
    if (layer.clip->has_box() && style->has_clip_box())
        return invalid("clip.box", "a layer has one clip box, and \"hybrid\" has it");
    return success();
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
    if (!message.has_clip() && message.clip_planes().empty() && !message.has_clip_box()) return success();
    MOTE_ASSIGN_OR_RETURN(layer.clip, parseClipOf(message));
    return checkClips(layer);
}

void writeLayerParts(const Layer& layer, proto::Layer& message) {
    if (layer.colorBy) *message.mutable_color_by() = *layer.colorBy;
    if (layer.select) *message.mutable_select() = toProto(*layer.select);
    if (layer.highlight) *message.mutable_highlight() = toProto(*layer.highlight);
    if (layer.paths) *message.mutable_paths() = *layer.paths;
    if (layer.clip) *message.mutable_clip() = *layer.clip;
    if (!layer.towards) return;
    message.mutable_towards()->set_step(layer.towards->step);
    message.mutable_towards()->set_share(layer.towards->share);
}

void visitLayer(Layer& layer, const Layer& other, FieldVisitor& visitor) {
    const bool keepsInk = layer.inkIsDark != other.inkIsDark;
    const auto ink = keepsInk ? layer.ink()->color() : google::protobuf::RepeatedField<double>();
    std::visit(
        [&](auto& style) {
            visitFields(style, std::get<std::decay_t<decltype(style)>>(other.style), visitor);
        },
        layer.style);
    if (keepsInk) {
        // Between ink for the dark and ink for the light it would vanish on its paper.
        *std::get<proto::InkStyle>(layer.style).mutable_color() = ink;
        visitor.word(false);
    }
    visitPart(layer.colorBy, other.colorBy, visitor);
    visitor.word(layer.select == other.select);
    visitPart(layer.highlight, other.highlight, visitor);
    visitPart(layer.paths, other.paths, visitor);
    visitPart(layer.clip, other.clip, visitor);
    visitTowards(layer, other, visitor);
}

std::size_t valueCount(const Layer& layer) {
    return (layer.select ? valueCount(*layer.select) : 0) +
           (layer.highlight ? valueCount(layer.highlight->selection) : 0);
}

}  // namespace mote
