// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/hybrid_style.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <string_view>
#include <utility>

#include "protocol/scene/curve_presets.h"
#include "protocol/scene/field_visitor.h"
#include "protocol/scene/fields/resolve.h"
#include "protocol/scene/mix.h"
#include "protocol/scene/write_fields.h"

namespace mote {
namespace {

// In the order of their enumerations.
constexpr std::array<std::string_view, 4> representations{"", "points", "residual", "volume"};
constexpr std::array<std::string_view, 3> shapes{"square", "disc", "gaussian"};
constexpr std::array<std::string_view, 3> shown{"", "maximum", "surface"};

using HybridKnots = google::protobuf::RepeatedPtrField<proto::HybridStyle::Knot>;

bool isColored(const HybridKnots& knots) {
    return !knots.empty() && !knots[0].color().empty();
}

Status validateHybridColors(proto::HybridStyle& style) {
    const bool colored = isColored(style.curve());
    for (int i = 0; i < style.curve_size(); ++i) {
        if (style.curve(i).color().empty() == colored)
            return invalid(fmt::format("curve[{}].color", i), "all knots of a curve have a color, or none");
    }
    if (colored && !style.color_map().empty()) return invalid("colorMap", "is instead of the knots' colors");
    const auto& range = style.color_range();
    if (range.empty() || range[0] < range[1]) return success();
    return invalid("colorRange", "the second value must be the greater one");
}

std::optional<Curve> hybridCurveOf(const HybridKnots& knots) {
    if (knots.empty()) return std::nullopt;
    std::vector<Curve::Knot> made;
    for (const auto& knot : knots) made.push_back({knot.value(), knot.opacity()});
    return Curve::create(std::move(made), -Curve::largest, Curve::largest).value();
}

/// The knots from the first of which to the last the colour map goes where nothing else is said.
bool hasSpan(const HybridKnots& knots) {
    return knots[0].value() < knots[knots.size() - 1].value();
}

bool hasPlainCurve(const proto::HybridStyle& style) {
    return !style.curve().empty() && !isColored(style.curve());
}

bool rangeByKnots(const proto::HybridStyle& style) {
    return hasPlainCurve(style) && style.color_range().empty();
}

}  // namespace

Result<proto::HybridStyle> parseHybridStyle(proto::HybridStyle message) {
    auto& light = *message.mutable_light();
    if (!light.has_ambient()) light.set_ambient(0.25);
    if (!light.has_diffuse()) light.set_diffuse(0.75);
    if (!light.has_specular()) light.set_specular(0.25);
    MOTE_ASSIGN_OR_RETURN(auto style, resolved(std::move(message)));
    if (style.light().shadow()) return invalid("light.shadow", "volumes cast no shadows");
    MOTE_RETURN_IF_ERROR(validateHybridColors(style));
    MOTE_RETURN_IF_ERROR(checkPlanes(*style.mutable_clip_planes(), "clipPlanes"));
    if (style.has_clip_box()) MOTE_RETURN_IF_ERROR(checkBox(style.clip_box(), "clipBox"));
    return style;
}

HybridStyle hybridStyleOf(const proto::HybridStyle& message) {
    HybridStyle style{
        .representation = enumOf<HybridRepresentation>(message.representation(), representations),
        .opacity = hybridCurveOf(message.curve()),
        .colors = {},
        .colorMap = ColorMap::find(message.color_map().empty() ? "viridis" : message.color_map()).value(),
        .colorRange = {},
        .ownColors = isColored(message.curve()) || !message.color_map().empty(),
        .pointShape = enumOf<PointShape>(message.point_shape(), shapes),
        .pointOpacity = message.point_opacity(),
        .light = lightOf(message.light()),
        .clipPlanes = halfSpacesOf(message.clip_planes(), nullptr),
        .clipBox = {},
        .shows = enumOf<HybridShows>(message.shows(), shown),
        .isovalue = {},
        .silhouettes = message.silhouettes(),
        .gradientOpacity = message.gradient_opacity()};
    if (message.has_isovalue()) style.isovalue = message.isovalue();
    if (message.has_clip_box())
        style.clipBox = Bounds{readVector(message.clip_box().min()), readVector(message.clip_box().max())};
    for (const auto& knot : message.curve()) {
        if (!knot.color().empty()) style.colors.push_back(readColor(knot.color()));
    }
    if (!message.color_range().empty())
        style.colorRange = ValueRange{message.color_range(0), message.color_range(1)};
    return style;
}

/// Where the colour map goes from the first knot to the last, the knots of two curves together span more than
/// either's: the colours go from the one's range to the other's.
void visitFields(proto::HybridStyle& style, const proto::HybridStyle& other, FieldVisitor& visitor) {
    auto& anyStyle = static_cast<google::protobuf::Message&>(style);
    if (&style == &other || !rangeByKnots(style) || !hasPlainCurve(other))
        return visitFields(anyStyle, other, visitor);
    const auto from = style.curve();
    const auto& to = other.curve();
    const bool asMany = from.size() == to.size();
    visitFields(anyStyle, other, visitor);
    if (hasSpan(from) != hasSpan(to) || !(hasSpan(from) || asMany)) {
        visitor.word(false);
        *style.mutable_curve() = from;
        return;
    }
    if (asMany || !canMix({*hybridCurveOf(from)}, {*hybridCurveOf(to)})) return;
    visitor.between([&](double share) {
        const ValueRange knots{mix(from[0].value(), to[0].value(), share),
                               mix(from[from.size() - 1].value(), to[to.size() - 1].value(), share)};
        const auto range = style.color_map().empty() ? readableColors(knots) : knots;
        style.clear_color_range();
        for (const double end : {range.low, range.high}) style.add_color_range(end);
    });
}

}  // namespace mote
