// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/ink_style.h"

#include <array>
#include <utility>
#include <vector>

#include "protocol/scene/field_visitor.h"
#include "protocol/scene/fields/facts.h"
#include "protocol/scene/fields/resolve.h"
#include "protocol/scene/srgb.h"
#include "protocol/scene/view.h"
#include "protocol/scene/write_fields.h"

namespace mote {
namespace {

// Names in the order of their enumerations.
constexpr std::array<std::string_view, 4> modes{"none", "all", "important", "adjusted"};
constexpr std::array<std::string_view, 4> segmentations{"growing", "graph", "cut", "texture"};
constexpr std::array<std::string_view, 10> pictures{"",           "grey",     "depth",  "angle",   "edges",
                                                    "complexity", "segments", "target", "lighten", "darken"};

/// A brush that inks nothing.
proto::InkStyle::Solid noBrush() {
    proto::InkStyle::Solid brush;
    brush.set_strength(0.0);
    fillIn(brush);
    return brush;
}

/// One that inks nothing, and by default nowhere, is as good as none.
void dropNoBrush(proto::InkStyle& style) {
    if (style.has_ink() && style.ink().SerializeAsString() == noBrush().SerializeAsString())
        style.clear_ink();
}

std::optional<Curve> inkCurveOf(const proto::InkStyle& message) {
    std::vector<Curve::Knot> knots;
    for (const auto& knot : message.curve()) knots.push_back({knot.value(), knot.opacity()});
    if (knots.empty()) return std::nullopt;
    return Curve::create(std::move(knots), -Curve::largest, Curve::largest).value();
}

}  // namespace

Result<proto::InkStyle> parseInkStyle(proto::InkStyle message, const glm::dvec3& background) {
    auto& silhouettes = *message.mutable_silhouettes();
    if (silhouettes.mode() == "important" && !silhouettes.has_importance()) silhouettes.set_importance(0.25);
    auto& light = *message.mutable_light();
    if (!light.has_ambient()) light.set_ambient(0.4);
    if (!light.has_diffuse()) light.set_diffuse(0.8);
    MOTE_ASSIGN_OR_RETURN(auto style, resolved(std::move(message)));
    dropNoBrush(style);
    if (style.color().empty())
        writeVector(glm::dvec3(isLight(background) ? 0.0 : 1.0), style.mutable_color());
    return style;
}

bool inkIsDark(const proto::InkStyle& message, const glm::dvec3& background) {
    return luminance(readColor(message.color())) <= luminance(background);
}

InkStyle inkStyleOf(const proto::InkStyle& message, bool inkIsDark) {
    const auto& lines = message.silhouettes();
    const auto& hatch = message.hatch();
    const auto brush = message.has_ink() ? message.ink() : noBrush();
    return {.silhouettes = {.mode = enumOf<SilhouetteMode>(lines.mode(), modes),
                            .importance = lines.importance(),
                            .width = lengthOf(lines, lines.kWidthFieldNumber),
                            .crease = lines.crease_degrees(),
                            .omit = lines.omit()},
            .hatch = {.strength = hatch.strength(),
                      .spacing = lengthOf(hatch, hatch.kSpacingFieldNumber),
                      .width = lengthOf(hatch, hatch.kWidthFieldNumber),
                      .segments = enumOf<Segmentation>(hatch.segments(), segmentations)},
            .solid = {brush.strength(), brush.complexity()},
            .reading = lengthOf(message, message.kReadingFieldNumber),
            .light = lightOf(message.light()),
            .occlusion = message.occlusion(),
            .color = readColor(message.color()),
            .inkIsDark = inkIsDark,
            .show = enumOf<InkPicture>(message.show(), pictures),
            .waver = lengthOf(message, message.kWaverFieldNumber),
            .taper = message.taper(),
            .opacity = inkCurveOf(message),
            .coherent = message.coherent()};
}

/// A brush comes and goes by its strength.
void visitFields(proto::InkStyle& style, const proto::InkStyle& other, FieldVisitor& visitor) {
    auto& anyStyle = static_cast<google::protobuf::Message&>(style);
    if (style.has_ink() == other.has_ink()) {
        visitFields(anyStyle, other, visitor);
    } else {
        proto::InkStyle brushed = other;
        *(style.has_ink() ? brushed : style).mutable_ink() = noBrush();
        visitFields(anyStyle, brushed, visitor);
    }
    dropNoBrush(style);
}

}  // namespace mote
