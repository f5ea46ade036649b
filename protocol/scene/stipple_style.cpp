// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/stipple_style.h"

#include <array>
#include <string_view>
#include <utility>

#include "protocol/scene/check.h"
#include "protocol/scene/srgb.h"
#include "protocol/scene/style_kinds.h"
#include "protocol/scene/write_fields.h"

namespace mote {
namespace {

constexpr std::array<std::pair<std::string_view, DotValue>, 6> valueNames{{{"", DotValue::none},
                                                                           {"tone", DotValue::tone},
                                                                           {"depth", DotValue::depth},
                                                                           {"x", DotValue::x},
                                                                           {"y", DotValue::y},
                                                                           {"z", DotValue::z}}};

Result<DotValue> parseValue(const std::string& name) {
    for (const auto& [known, value] : valueNames) {
        if (known == name) return value;
    }
    return Error{ErrorCode::invalidArgument, "value",
                 "there are \"tone\", \"depth\", \"x\", \"y\" and \"z\""};
}

constexpr LengthField spacingField{"stipple.spacingPixels", 0.5, 1000.0};
constexpr LengthField dotField{"stipple.dotPixels", 0.1, 64.0};
constexpr LengthField leastDotField{"stipple.leastDotPixels", 0.1, 64.0};

Status parseSizes(const proto::StippleStyle& message, StippleStyle& style) {
    MOTE_ASSIGN_OR_RETURN(style.spacing, checkLength(message.has_spacing_pixels(), message.spacing_pixels(),
                                                     style.spacing, spacingField));
    MOTE_ASSIGN_OR_RETURN(
        style.dotSize, checkLength(message.has_dot_pixels(), message.dot_pixels(), style.dotSize, dotField));
    MOTE_ASSIGN_OR_RETURN(style.leastDotSize,
                          checkLength(message.has_least_dot_pixels(), message.least_dot_pixels(),
                                      style.dotSize, leastDotField));
    return success();
}

bool isDarker(const glm::dvec3& ink, const glm::dvec3& paper) {
    return luminance(ink) < luminance(paper);
}

Status parseColors(const proto::StippleStyle& message, const glm::dvec3& background, StippleStyle& style) {
    MOTE_ASSIGN_OR_RETURN(const auto color,
                          checkColor(message.color(), glm::dvec3(isLight(background) ? 0.0 : 1.0), "color"));
    MOTE_ASSIGN_OR_RETURN(style.opacity, checkRange(message.has_opacity() ? message.opacity() : style.opacity,
                                                    0.0, 1.0, "opacity"));
    MOTE_ASSIGN_OR_RETURN(style.value, parseValue(message.value()));
    style.color = color;
    style.denseDark = isDarker(color, background) != message.invert();
    if (message.color_map().empty()) return success();
    const auto map = ColorMap::find(message.color_map());
    if (!map.ok()) return map.error().within("colorMap");
    style.colorMap = *map;
    return success();
}

Status parseSource(const proto::StippleStyle& message, StippleStyle& style) {
    if (!message.source().empty() && message.source() != "layers") {
        return Error{ErrorCode::invalidArgument, "source", "there is only \"layers\""};
    }
    if (!message.source().empty() && !message.image().empty()) {
        return Error{ErrorCode::invalidArgument, "source", "is instead of an image, not beside it"};
    }
    style.image = message.image();
    style.sourceLayers = !message.source().empty();
    return success();
}

void writeSizes(const StippleStyle& style, proto::StippleStyle& message) {
    if (style.spacing.said()) message.set_spacing_pixels(style.spacing);
    if (style.dotSize.said()) message.set_dot_pixels(style.dotSize);
    if (style.leastDotSize.said()) message.set_least_dot_pixels(style.leastDotSize);
}

}  // namespace

Result<StippleStyle> parseStippleStyle(const proto::StippleStyle& message, const glm::dvec3& background) {
    StippleStyle style;
    MOTE_RETURN_IF_ERROR(parseSizes(message, style));
    MOTE_RETURN_IF_ERROR(parseColors(message, background, style));
    MOTE_RETURN_IF_ERROR(parseSource(message, style));
    const auto light = parseLight(message.light());
    if (!light.ok()) return light.error().within("light");
    MOTE_ASSIGN_OR_RETURN(
        style.jitter, checkRange(message.has_jitter() ? message.jitter() : style.jitter, 0.0, 4.0, "jitter"));
    MOTE_ASSIGN_OR_RETURN(
        style.gamma, checkRange(message.has_gamma() ? message.gamma() : style.gamma, 0.05, 20.0, "gamma"));
    style.light = *light;
    style.soft = message.soft();
    style.seeThrough = message.see_through();
    return style;
}

void writeStyle(const StippleStyle& style, const glm::dvec3& background, proto::Layer& layer) {
    auto& message = *layer.mutable_stipple();
    writeSizes(style, message);
    message.set_opacity(style.opacity);
    const auto color = writeColor(style.color, message.mutable_color());
    message.set_invert(isDarker(color, background) != style.denseDark);
    for (const auto& [name, value] : valueNames) {
        if (value == style.value) message.set_value(std::string(name));
    }
    if (style.colorMap) message.set_color_map(std::string(style.colorMap->name()));
    *message.mutable_light() = toProto(style.light);
    message.set_gamma(style.gamma);
    message.set_jitter(style.jitter);
    message.set_soft(style.soft);
    message.set_see_through(style.seeThrough);
    message.set_image(style.image);
    if (style.sourceLayers) message.set_source("layers");
}

void visitFields(StippleStyle& style, const StippleStyle& other, FieldVisitor& visitor) {
    visitor.pixels(style.spacing, other.spacing, spacingField);
    visitor.pixels(style.dotSize, other.dotSize, dotField);
    visitor.pixels(style.leastDotSize, other.leastDotSize, leastDotField);
    visitor.number(style.opacity, other.opacity);
    visitor.vector(style.color, other.color);
    visitor.light(style.light, other.light);
    visitor.number(style.gamma, other.gamma);
    visitor.number(style.jitter, other.jitter);
    visitor.word(style.value == other.value && style.colorMap == other.colorMap);
    visitor.word(style.denseDark == other.denseDark && style.soft == other.soft);
    visitor.word(style.seeThrough == other.seeThrough);
    visitor.word(style.image == other.image && style.sourceLayers == other.sourceLayers);
}

}  // namespace mote
