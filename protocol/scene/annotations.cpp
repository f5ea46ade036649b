// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/annotations.h"

#include <fmt/format.h>

#include "protocol/scene/check.h"
#include "protocol/scene/mix.h"
#include "protocol/scene/write_fields.h"

namespace mote {
namespace {

constexpr double inch = 25.4;              // mm
constexpr double pointsInInch = 72.0;      // of type
constexpr double pixelsInInch = 96.0;      // where nobody says how wide a picture is printed
constexpr std::size_t longestTitle = 256;  // bytes

Status checkTitle(const std::string& title) {
    const auto invalid = [](std::string message) {
        return Error{ErrorCode::invalidArgument, "title", std::move(message)};
    };
    if (title.size() > longestTitle) return invalid(fmt::format("is longer than {} bytes", longestTitle));
    for (const unsigned char c : title) {
        if (c < 0x20 || c == 0x7f) return invalid("holds a control character");
    }
    return success();
}

double widthAtScreen(std::uint32_t width) {
    return width * inch / pixelsInInch;
}

}  // namespace

double Annotations::fontPixels(std::uint32_t width) const {
    return fontPoints / pointsInInch * inch * width / printWidth.value_or(widthAtScreen(width));
}

Result<Annotations> parseAnnotations(const proto::Annotations& message) {
    Annotations annotations;
    annotations.axes = message.axes();
    annotations.colorBar = message.color_bar();
    annotations.scaleBar = message.scale_bar();
    annotations.labels = message.labels();
    MOTE_RETURN_IF_ERROR(checkTitle(message.title()));
    annotations.title = message.title();
    const double points = message.has_font_points() ? message.font_points() : annotations.fontPoints;
    MOTE_ASSIGN_OR_RETURN(annotations.fontPoints, checkRange(points, 1.0, 200.0, "fontPoints"));
    if (message.has_print_width()) {
        MOTE_ASSIGN_OR_RETURN(annotations.printWidth,
                              checkRange(message.print_width(), 0.1, 1e5, "printWidth"));
    }
    if (!message.color().empty()) {
        MOTE_ASSIGN_OR_RETURN(annotations.color, checkColor(message.color(), glm::dvec3(0.0), "color"));
    }
    return annotations;
}

proto::Annotations toProto(const Annotations& annotations) {
    proto::Annotations message;
    message.set_axes(annotations.axes);
    message.set_color_bar(annotations.colorBar);
    message.set_scale_bar(annotations.scaleBar);
    message.set_labels(annotations.labels);
    message.set_title(annotations.title);
    message.set_font_points(annotations.fontPoints);
    if (annotations.printWidth) message.set_print_width(*annotations.printWidth);
    if (annotations.color) writeColor(*annotations.color, message.mutable_color());
    return message;
}

Annotations magnified(const Annotations& annotations, std::uint32_t width) {
    Annotations result = annotations;
    if (!result.printWidth) result.printWidth = widthAtScreen(width);
    return result;
}

std::optional<Annotations> mixAnnotations(const std::optional<Annotations>& from,
                                          const std::optional<Annotations>& to, double share) {
    if (!from || !to) return from;
    Annotations result = *from;
    result.fontPoints = mix(from->fontPoints, to->fontPoints, share);
    if (from->printWidth && to->printWidth)
        result.printWidth = mix(*from->printWidth, *to->printWidth, share);
    if (from->color && to->color) result.color = mix(*from->color, *to->color, share);
    return result;
}

}  // namespace mote
