// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/ink_style.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "protocol/scene/check.h"
#include "protocol/scene/mix_curve.h"
#include "protocol/scene/srgb.h"
#include "protocol/scene/style_kinds.h"
#include "protocol/scene/write_fields.h"

namespace mote {
namespace {

constexpr double largestValue = 1e30;  // of a value

constexpr LengthField lineWidthField{"ink.silhouettes.width", 0.1, 64.0};
constexpr LengthField hatchSpacingField{"ink.hatch.spacing", 1.0, 256.0};
constexpr LengthField hatchWidthField{"ink.hatch.width", 0.1, 64.0};
constexpr LengthField readingField{"ink.reading", 1.0, 256.0};
constexpr LengthField waverField{"ink.waver", 0.0, 16.0};

// Names in the order of their enumerations.
constexpr std::array<std::string_view, 4> modes{"none", "all", "important", "adjusted"};
constexpr std::array<std::string_view, 4> segmentations{"growing", "graph", "cut", "texture"};
constexpr std::array<std::string_view, 10> pictures{"",           "grey",     "depth",  "angle",   "edges",
                                                    "complexity", "segments", "target", "lighten", "darken"};

/// A name's place in a list; `fallback` where it is "".
template <class Enum, std::size_t N>
Result<Enum> parseName(const std::string& name, const std::array<std::string_view, N>& names, Enum fallback,
                       std::string_view field) {
    if (name.empty()) return fallback;
    const auto found = std::find(names.begin(), names.end(), name);
    if (found != names.end()) return static_cast<Enum>(found - names.begin());
    const auto known = std::span(names).subspan(names[0].empty() ? 1 : 0);
    return Error{ErrorCode::invalidArgument, std::string(field),
                 fmt::format("\"{}\" is not known: there are {}", name, fmt::join(known, ", "))};
}

template <class Message>
Result<SilhouetteStyle> parseSilhouettes(const Message& message) {
    SilhouetteStyle style;
    MOTE_ASSIGN_OR_RETURN(style.mode, parseName(message.mode(), modes, style.mode, "mode"));
    if (style.mode == SilhouetteMode::important) style.importance = 0.25;
    const double importance = message.has_importance() ? message.importance() : style.importance;
    MOTE_ASSIGN_OR_RETURN(style.importance, checkRange(importance, 0.0, 1.0, "importance"));
    MOTE_ASSIGN_OR_RETURN(style.width,
                          checkLength(message.has_width(), message.width(), style.width, lineWidthField));
    const double crease = message.has_crease_degrees() ? message.crease_degrees() : style.crease;
    MOTE_ASSIGN_OR_RETURN(style.crease, checkRange(crease, 0.0, 180.0, "creaseDegrees"));
    style.omit = message.omit();
    return style;
}

template <class Message>
Result<HatchStyle> parseHatch(const Message& message) {
    HatchStyle style;
    const double strength = message.has_strength() ? message.strength() : style.strength;
    MOTE_ASSIGN_OR_RETURN(style.strength, checkRange(strength, 0.0, 1.0, "strength"));
    MOTE_ASSIGN_OR_RETURN(style.spacing, checkLength(message.has_spacing(), message.spacing(), style.spacing,
                                                     hatchSpacingField));
    MOTE_ASSIGN_OR_RETURN(style.width,
                          checkLength(message.has_width(), message.width(), style.width, hatchWidthField));
    MOTE_ASSIGN_OR_RETURN(style.segments,
                          parseName(message.segments(), segmentations, style.segments, "segments"));
    return style;
}

template <class Message>
Result<SolidStyle> parseSolid(const Message& message) {
    SolidStyle style;
    const double strength = message.has_strength() ? message.strength() : 0.5;
    MOTE_ASSIGN_OR_RETURN(style.strength, checkRange(strength, 0.0, 1.0, "strength"));
    const double complexity = message.has_complexity() ? message.complexity() : style.complexity;
    MOTE_ASSIGN_OR_RETURN(style.complexity, checkRange(complexity, 0.0, 1.0, "complexity"));
    return style;
}

Result<std::optional<Curve>> parseCurve(const proto::InkStyle& message) {
    if (message.curve().empty()) return std::optional<Curve>();
    std::vector<Curve::Knot> knots;
    for (const auto& knot : message.curve()) knots.push_back({knot.value(), knot.opacity()});
    auto curve = Curve::create(std::move(knots), -largestValue, largestValue);
    if (!curve.ok()) return curve.error();
    return std::optional(*std::move(curve));
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
    visitor.pixels(silhouettes.width, other.silhouettes.width, lineWidthField);
    visitor.number(silhouettes.crease, other.silhouettes.crease);
    visitor.word(style.hatch.segments == other.hatch.segments);
    visitor.number(style.hatch.strength, other.hatch.strength);
    visitor.pixels(style.hatch.spacing, other.hatch.spacing, hatchSpacingField);
    visitor.pixels(style.hatch.width, other.hatch.width, hatchWidthField);
    visitor.number(style.solid.strength, other.solid.strength);
    visitor.number(style.solid.complexity, other.solid.complexity);
}

template <class Value>
Status take(Result<Value> parsed, Value& value, std::string_view field) {
    if (!parsed.ok()) return parsed.error().within(field);
    value = *std::move(parsed);
    return success();
}

}  // namespace

Result<InkStyle> parseInkStyle(const proto::InkStyle& message, const glm::dvec3& background) {
    InkStyle style;
    MOTE_RETURN_IF_ERROR(take(parseSilhouettes(message.silhouettes()), style.silhouettes, "silhouettes"));
    MOTE_RETURN_IF_ERROR(take(parseHatch(message.hatch()), style.hatch, "hatch"));
    if (message.has_ink()) MOTE_RETURN_IF_ERROR(take(parseSolid(message.ink()), style.solid, "ink"));
    MOTE_ASSIGN_OR_RETURN(style.reading,
                          checkLength(message.has_reading(), message.reading(), style.reading, readingField));
    MOTE_RETURN_IF_ERROR(take(parseLight(message.light()), style.light, "light"));
    MOTE_ASSIGN_OR_RETURN(style.occlusion, checkRange(message.occlusion(), 0.0, 1.0, "occlusion"));
    const glm::dvec3 shows(isLight(background) ? 0.0 : 1.0);
    MOTE_ASSIGN_OR_RETURN(style.color, checkColor(message.color(), shows, "color"));
    style.inkIsDark = luminance(style.color) <= luminance(background);
    MOTE_ASSIGN_OR_RETURN(style.show, parseName(message.show(), pictures, style.show, "show"));
    MOTE_ASSIGN_OR_RETURN(style.waver,
                          checkLength(message.has_waver(), message.waver(), style.waver, waverField));
    style.taper = message.taper();
    style.coherent = message.coherent();
    MOTE_RETURN_IF_ERROR(take(parseCurve(message), style.opacity, "curve"));
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
    visitor.pixels(style.reading, other.reading, readingField);
    visitor.light(style.light, other.light);
    visitor.number(style.occlusion, other.occlusion);
    visitor.word(style.inkIsDark == other.inkIsDark);
    if (style.inkIsDark == other.inkIsDark) visitor.vector(style.color, other.color);
    visitor.word(style.show == other.show && style.taper == other.taper && style.coherent == other.coherent);
    visitor.pixels(style.waver, other.waver, waverField);
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
