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
#include "protocol/scene/srgb.h"

namespace mote {
namespace {

constexpr double largest = 1e30;  // of a value

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
    const double width = message.has_width() ? message.width() : style.width;
    MOTE_ASSIGN_OR_RETURN(style.width, checkRange(width, 0.1, 64.0, "width"));
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
    const double spacing = message.has_spacing() ? message.spacing() : style.spacing;
    MOTE_ASSIGN_OR_RETURN(style.spacing, checkRange(spacing, 1.0, 256.0, "spacing"));
    const double width = message.has_width() ? message.width() : style.width;
    MOTE_ASSIGN_OR_RETURN(style.width, checkRange(width, 0.1, 64.0, "width"));
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
    auto curve = Curve::create(std::move(knots), -largest, largest);
    if (!curve.ok()) return curve.error();
    return std::optional(*std::move(curve));
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
    const double reading = message.has_reading() ? message.reading() : style.reading;
    MOTE_ASSIGN_OR_RETURN(style.reading, checkRange(reading, 1.0, 256.0, "reading"));
    MOTE_RETURN_IF_ERROR(take(parseLight(message.light()), style.light, "light"));
    MOTE_ASSIGN_OR_RETURN(style.occlusion, checkRange(message.occlusion(), 0.0, 1.0, "occlusion"));
    const glm::dvec3 shows(isLight(background) ? 0.0 : 1.0);
    MOTE_ASSIGN_OR_RETURN(style.color, checkColor(message.color(), shows, "color"));
    style.inkIsDark = luminance(style.color) <= luminance(background);
    MOTE_ASSIGN_OR_RETURN(style.show, parseName(message.show(), pictures, style.show, "show"));
    MOTE_ASSIGN_OR_RETURN(style.waver, checkRange(message.waver(), 0.0, 16.0, "waver"));
    style.taper = message.taper();
    style.coherent = message.coherent();
    MOTE_RETURN_IF_ERROR(take(parseCurve(message), style.opacity, "curve"));
    return style;
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
