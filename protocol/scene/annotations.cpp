// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/annotations.h"

#include <fmt/format.h>

#include <algorithm>

#include "protocol/scene/fields/facts.h"
#include "protocol/scene/fields/resolve.h"
#include "protocol/scene/mix.h"
#include "protocol/scene/write_fields.h"

namespace mote {
namespace {

constexpr double pixelsInInch = 96.0;      // where nobody says how wide a picture is printed
constexpr std::size_t longestTitle = 256;  // bytes
constexpr double leastPrintWidth = 0.1;    // mm

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

/// How wide the picture would be printed, for letters to be as large as its view wants them.
double printWidthOf(const Annotations& annotations, std::uint32_t width, std::uint32_t height, double scale) {
    if (annotations.printWidth) return *annotations.printWidth;
    const double times = lengthScale(height, scale, annotations.fontPoints.said());
    return std::max(leastPrintWidth, width * inchInMillimeters / pixelsInInch / times);
}

}  // namespace

double Annotations::fontPixels(std::uint32_t width, std::uint32_t height, double scale) const {
    return fontPoints / inchInPoints * inchInMillimeters * width / printWidthOf(*this, width, height, scale);
}

Result<Annotations> parseAnnotations(const proto::Annotations& message) {
    Annotations annotations;
    annotations.axes = message.axes();
    annotations.colorBar = message.color_bar();
    annotations.scaleBar = message.scale_bar();
    annotations.labels = message.labels();
    MOTE_RETURN_IF_ERROR(checkTitle(message.title()));
    MOTE_RETURN_IF_ERROR(checkFields(message));
    annotations.title = message.title();
    annotations.fontPoints = lengthOf(message, message.kFontPointsFieldNumber);
    if (message.has_print_width()) annotations.printWidth = message.print_width();
    annotations.color = colorOf(message, message.kColorFieldNumber);
    return annotations;
}

proto::Annotations toProto(const Annotations& annotations) {
    proto::Annotations message;
    message.set_axes(annotations.axes);
    message.set_color_bar(annotations.colorBar);
    message.set_scale_bar(annotations.scaleBar);
    message.set_labels(annotations.labels);
    message.set_title(annotations.title);
    if (annotations.fontPoints.said()) message.set_font_points(annotations.fontPoints);
    if (annotations.printWidth) message.set_print_width(*annotations.printWidth);
    if (annotations.color) writeColor(*annotations.color, message.mutable_color());
    return message;
}

Annotations inPixels(const Annotations& annotations, std::uint32_t width, std::uint32_t height,
                     double scale) {
    Annotations result = annotations;
    result.printWidth = printWidthOf(annotations, width, height, scale);
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
