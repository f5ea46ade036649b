// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/stipple_style.h"

#include <array>
#include <string_view>
#include <utility>

#include "protocol/scene/check.h"
#include "protocol/scene/srgb.h"

namespace mote {
namespace {

Result<DotValue> parseValue(const std::string& name) {
    constexpr std::array<std::pair<std::string_view, DotValue>, 6> values{{{"", DotValue::none},
                                                                           {"tone", DotValue::tone},
                                                                           {"depth", DotValue::depth},
                                                                           {"x", DotValue::x},
                                                                           {"y", DotValue::y},
                                                                           {"z", DotValue::z}}};
    for (const auto& [known, value] : values) {
        if (known == name) return value;
    }
    return Error{ErrorCode::invalidArgument, "value",
                 "there are \"tone\", \"depth\", \"x\", \"y\" and \"z\""};
}

Status parseSizes(const proto::StippleStyle& message, StippleStyle& style) {
    MOTE_ASSIGN_OR_RETURN(style.spacing,
                          checkRange(message.has_spacing_pixels() ? message.spacing_pixels() : style.spacing,
                                     0.5, 1000.0, "spacingPixels"));
    MOTE_ASSIGN_OR_RETURN(
        const auto size,
        checkRange(message.has_dot_pixels() ? message.dot_pixels() : style.dotSize, 0.1, 64.0, "dotPixels"));
    MOTE_ASSIGN_OR_RETURN(style.leastDotSize,
                          checkRange(message.has_least_dot_pixels() ? message.least_dot_pixels() : size, 0.1,
                                     64.0, "leastDotPixels"));
    style.dotSize = size;
    return success();
}

Status parseColors(const proto::StippleStyle& message, const glm::dvec3& background, StippleStyle& style) {
    MOTE_ASSIGN_OR_RETURN(const auto color,
                          checkColor(message.color(), glm::dvec3(isLight(background) ? 0.0 : 1.0), "color"));
    MOTE_ASSIGN_OR_RETURN(style.opacity, checkRange(message.has_opacity() ? message.opacity() : style.opacity,
                                                    0.0, 1.0, "opacity"));
    MOTE_ASSIGN_OR_RETURN(style.value, parseValue(message.value()));
    style.color = color;
    style.denseDark = (luminance(color) < luminance(background)) != message.invert();
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

}  // namespace mote
