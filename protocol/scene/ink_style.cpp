// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/ink_style.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
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
constexpr std::array<std::string_view, 5> fills{"", "hatch", "ink", "wash", "none"};
constexpr std::array<std::string_view, 10> pictures{"",           "grey",     "depth",  "angle",   "edges",
                                                    "complexity", "segments", "target", "lighten", "darken"};

/// A brush that inks nothing, or a wash without pigment.
template <class Part>
Part nothingOf() {
    Part part;
    part.set_strength(0.0);
    fillIn(part);
    return part;
}

/// One that draws nothing, and is else as by default, is as good as none.
void dropNothing(proto::InkStyle& style) {
    const auto is = [](const auto& part, const auto& nothing) {
        return part.SerializeAsString() == nothing.SerializeAsString();
    };
    if (style.has_ink() && is(style.ink(), nothingOf<proto::InkStyle::Solid>())) style.clear_ink();
    if (style.has_wash() && is(style.wash(), nothingOf<proto::InkStyle::Wash>())) style.clear_wash();
}

Status checkRegion(const proto::InkStyle::Region& region) {
    const int numbers = region.dabs_size();
    if (numbers == 0 || numbers % 3 != 0)
        return invalid("dabs", fmt::format("three numbers a dab are needed, not {} in all", numbers));
    if (numbers > 3 * mostInkDabs)
        return invalid("dabs", fmt::format("at most {} dabs, not {}", mostInkDabs, numbers / 3));
    if (!(region.radius() > 0.0)) return invalid("radius", "a radius above 0 is needed");
    return success();
}

Status checkRegions(const proto::InkStyle& style) {
    if (style.regions_size() > mostInkRegions)
        return invalid("regions", fmt::format("at most {}, not {}", mostInkRegions, style.regions_size()));
    for (int i = 0; i < style.regions_size(); ++i)
        MOTE_RETURN_IF_ERROR(checkRegion(style.regions(i)), fmt::format("regions[{}]", i));
    return success();
}

WashStyle washOf(const proto::InkStyle& message) {
    auto wash = message.wash();
    fillIn(wash);
    return {.everywhere = message.has_wash(),
            .color = readColor(wash.color()),
            .strength = wash.strength(),
            .tones = static_cast<int>(std::lround(wash.tones())),
            .edges = wash.edges(),
            .granulation = wash.granulation(),
            .bleed = lengthOf(wash, wash.kBleedFieldNumber)};
}

std::vector<PaintedRegion> regionsOf(const proto::InkStyle& message) {
    std::vector<PaintedRegion> regions;
    for (const auto& region : message.regions()) {
        PaintedRegion made{.dabs = {},
                           .radius = region.radius(),
                           .whole = region.whole(),
                           .fill = enumOf<RegionFill>(region.fill(), fills),
                           .direction = std::nullopt};
        for (int i = 0; i + 2 < region.dabs_size(); i += 3)
            made.dabs.emplace_back(region.dabs(i), region.dabs(i + 1), region.dabs(i + 2));
        if (region.has_direction_degrees()) made.direction = region.direction_degrees();
        regions.push_back(std::move(made));
    }
    return regions;
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
    MOTE_RETURN_IF_ERROR(checkRegions(style));
    dropNothing(style);
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
    const auto brush = message.has_ink() ? message.ink() : nothingOf<proto::InkStyle::Solid>();
    return {.silhouettes = {.mode = enumOf<SilhouetteMode>(lines.mode(), modes),
                            .importance = lines.importance(),
                            .width = lengthOf(lines, lines.kWidthFieldNumber),
                            .crease = lines.crease_degrees(),
                            .omit = lines.omit(),
                            .suggestive = lines.suggestive()},
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
            .coherent = message.coherent(),
            .wash = washOf(message),
            .regions = regionsOf(message)};
}

/// A brush and a wash come and go by their strength.
void visitFields(proto::InkStyle& style, const proto::InkStyle& other, FieldVisitor& visitor) {
    auto& anyStyle = static_cast<google::protobuf::Message&>(style);
    if (style.has_ink() == other.has_ink() && style.has_wash() == other.has_wash()) {
        visitFields(anyStyle, other, visitor);
    } else {
        proto::InkStyle whole = other;
        if (style.has_ink() != other.has_ink())
            *(style.has_ink() ? whole : style).mutable_ink() = nothingOf<proto::InkStyle::Solid>();
        if (style.has_wash() != other.has_wash())
            *(style.has_wash() ? whole : style).mutable_wash() = nothingOf<proto::InkStyle::Wash>();
        visitFields(anyStyle, whole, visitor);
    }
    dropNothing(style);
}

}  // namespace mote
