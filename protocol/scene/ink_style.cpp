// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/ink_style.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "protocol/scene/fields/facts.h"
#include "protocol/scene/fields/resolve.h"
#include "protocol/scene/mix_curve.h"
#include "protocol/scene/srgb.h"
#include "protocol/scene/style_kinds.h"
#include "protocol/scene/write_fields.h"

namespace mote {
namespace {

// Names in the order of their enumerations.
constexpr std::array<std::string_view, 4> modes{"none", "all", "important", "adjusted"};
constexpr std::array<std::string_view, 4> segmentations{"growing", "graph", "cut", "texture"};
constexpr std::array<std::string_view, 10> pictures{"",           "grey",     "depth",  "angle",   "edges",
                                                    "complexity", "segments", "target", "lighten", "darken"};

/// A name's place in a list that has it.
template <class Enum, std::size_t N>
Enum valueOf(const std::string& name, const std::array<std::string_view, N>& names) {
    return static_cast<Enum>(std::find(names.begin(), names.end(), name) - names.begin());
}

SilhouetteStyle silhouettesOf(const proto::InkStyle::Silhouettes& message) {
    return {.mode = valueOf<SilhouetteMode>(message.mode(), modes),
            .importance = message.importance(),
            .width = lengthOf(message, message.kWidthFieldNumber),
            .crease = message.crease_degrees(),
            .omit = message.omit()};
}

HatchStyle hatchOf(const proto::InkStyle::Hatch& message) {
    return {.strength = message.strength(),
            .spacing = lengthOf(message, message.kSpacingFieldNumber),
            .width = lengthOf(message, message.kWidthFieldNumber),
            .segments = valueOf<Segmentation>(message.segments(), segmentations)};
}

std::optional<Curve> curveOf(const proto::InkStyle& message) {
    std::vector<Curve::Knot> knots;
    for (const auto& knot : message.curve()) knots.push_back({knot.value(), knot.opacity()});
    if (knots.empty()) return std::nullopt;
    return Curve::create(std::move(knots), -Curve::largest, Curve::largest).value();
}

void writeLines(const InkStyle& style, proto::InkStyle& message) {
    auto& silhouettes = *message.mutable_silhouettes();
    silhouettes.set_mode(std::string(toString(style.silhouettes.mode)));
    silhouettes.set_importance(style.silhouettes.importance);
    if (style.silhouettes.width.said()) silhouettes.set_width(style.silhouettes.width);
    silhouettes.set_crease_degrees(style.silhouettes.crease);
    silhouettes.set_omit(style.silhouettes.omit);
    auto& hatch = *message.mutable_hatch();
    hatch.set_strength(style.hatch.strength);
    if (style.hatch.spacing.said()) hatch.set_spacing(style.hatch.spacing);
    if (style.hatch.width.said()) hatch.set_width(style.hatch.width);
    hatch.set_segments(std::string(toString(style.hatch.segments)));
    if (style.solid == SolidStyle{}) return;
    message.mutable_ink()->set_strength(style.solid.strength);
    message.mutable_ink()->set_complexity(style.solid.complexity);
}

/// What is drawn of a volume or particles.
void visitOpacity(InkStyle& style, const InkStyle& other, FieldVisitor& visitor) {
    visitor.word(style.opacity.has_value() == other.opacity.has_value());
    if (style.opacity && other.opacity) visitCurve(visitor, *style.opacity, *other.opacity);
}

void visitLines(InkStyle& style, const InkStyle& other, FieldVisitor& visitor) {
    auto& silhouettes = style.silhouettes;
    visitor.word(silhouettes.mode == other.silhouettes.mode && silhouettes.omit == other.silhouettes.omit);
    visitor.number(silhouettes.importance, other.silhouettes.importance);
    visitor.pixels(silhouettes.width, other.silhouettes.width, lengthField("ink.silhouettes.width"));
    visitor.number(silhouettes.crease, other.silhouettes.crease);
    visitor.word(style.hatch.segments == other.hatch.segments);
    visitor.number(style.hatch.strength, other.hatch.strength);
    visitor.pixels(style.hatch.spacing, other.hatch.spacing, lengthField("ink.hatch.spacing"));
    visitor.pixels(style.hatch.width, other.hatch.width, lengthField("ink.hatch.width"));
    visitor.number(style.solid.strength, other.solid.strength);
    visitor.number(style.solid.complexity, other.solid.complexity);
}

}  // namespace

Result<proto::InkStyle> resolvedInk(proto::InkStyle message) {
    auto& silhouettes = *message.mutable_silhouettes();
    if (silhouettes.mode() == "important" && !silhouettes.has_importance()) silhouettes.set_importance(0.25);
    return resolved(std::move(message));
}

Result<InkStyle> parseInkStyle(const proto::InkStyle& said, const glm::dvec3& background) {
    MOTE_ASSIGN_OR_RETURN(const auto message, resolvedInk(said));
    InkStyle style;
    style.silhouettes = silhouettesOf(message.silhouettes());
    style.hatch = hatchOf(message.hatch());
    if (message.has_ink()) style.solid = {message.ink().strength(), message.ink().complexity()};
    style.reading = lengthOf(message, message.kReadingFieldNumber);
    style.light = lightOf(message.light());
    style.occlusion = message.occlusion();
    const glm::dvec3 shows(isLight(background) ? 0.0 : 1.0);
    style.color = colorOf(message, message.kColorFieldNumber).value_or(shows);
    style.inkIsDark = luminance(style.color) <= luminance(background);
    style.show = valueOf<InkPicture>(message.show(), pictures);
    style.waver = lengthOf(message, message.kWaverFieldNumber);
    style.taper = message.taper();
    style.coherent = message.coherent();
    style.opacity = curveOf(message);
    return style;
}

void writeStyle(const InkStyle& style, const glm::dvec3&, proto::Layer& layer) {
    auto& message = *layer.mutable_ink();
    writeLines(style, message);
    if (style.reading.said()) message.set_reading(style.reading);
    *message.mutable_light() = toProto(style.light);
    message.set_occlusion(style.occlusion);
    writeColor(style.color, message.mutable_color());
    message.set_show(std::string(toString(style.show)));
    if (style.waver.said()) message.set_waver(style.waver);
    message.set_taper(style.taper);
    message.set_coherent(style.coherent);
    for (const auto& knot : style.opacity ? style.opacity->knots() : std::vector<Curve::Knot>()) {
        auto& added = *message.add_curve();
        added.set_value(knot.x);
        added.set_opacity(knot.y);
    }
}

/// Ink that stands for the dark keeps its colour where the other's stands for the light: between them it
/// would vanish on its paper and come back as the other.
void visitFields(InkStyle& style, const InkStyle& other, FieldVisitor& visitor) {
    visitLines(style, other, visitor);
    visitor.pixels(style.reading, other.reading, lengthField("ink.reading"));
    visitor.light(style.light, other.light);
    visitor.number(style.occlusion, other.occlusion);
    visitor.word(style.inkIsDark == other.inkIsDark);
    if (style.inkIsDark == other.inkIsDark) visitor.vector(style.color, other.color);
    visitor.word(style.show == other.show && style.taper == other.taper && style.coherent == other.coherent);
    visitor.pixels(style.waver, other.waver, lengthField("ink.waver"));
    visitOpacity(style, other, visitor);
}

std::string_view toString(SilhouetteMode mode) {
    return modes[static_cast<std::size_t>(mode)];
}

std::string_view toString(Segmentation segments) {
    return segmentations[static_cast<std::size_t>(segments)];
}

std::string_view toString(InkPicture picture) {
    return pictures[static_cast<std::size_t>(picture)];
}

}  // namespace mote
