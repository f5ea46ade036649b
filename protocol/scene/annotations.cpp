// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/annotations.h"

#include <fmt/format.h>

#include <algorithm>

#include "protocol/scene/fields/facts.h"
#include "protocol/scene/fields/resolve.h"
#include "protocol/scene/length_scale.h"

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
double printWidthOf(const proto::Annotations& annotations, std::uint32_t width, std::uint32_t height,
                    double scale) {
    if (annotations.has_print_width()) return annotations.print_width();
    const double times = lengthScale(height, scale, annotations.has_font_points());
    return std::max(leastPrintWidth, width * inchInMillimeters / pixelsInInch / times);
}

}  // namespace

double fontPixels(const proto::Annotations& annotations, std::uint32_t width, std::uint32_t height,
                  double scale) {
    const double points = lengthOf(annotations, annotations.kFontPointsFieldNumber);
    return points / inchInPoints * inchInMillimeters * width /
           printWidthOf(annotations, width, height, scale);
}

Status checkAnnotations(const proto::Annotations& message) {
    MOTE_RETURN_IF_ERROR(checkTitle(message.title()));
    return checkFields(message);
}

proto::Annotations inPixels(proto::Annotations annotations, std::uint32_t width, std::uint32_t height,
                            double scale) {
    annotations.set_print_width(printWidthOf(annotations, width, height, scale));
    return annotations;
}

}  // namespace mote
