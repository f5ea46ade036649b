// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/color_by.h"

#include <fmt/format.h>

#include "protocol/quantity/quantity.h"
#include "protocol/scene/fields/resolve.h"

namespace mote {

Result<ColorBy> parseColorBy(const proto::ColorBy& said) {
    ColorBy colorBy;
    MOTE_ASSIGN_OR_RETURN(colorBy.column, checkColumnName(said.column(), "column"));
    MOTE_ASSIGN_OR_RETURN(const auto message, resolved(said));
    if (!message.range().empty()) colorBy.range = ValueRange{message.range(0), message.range(1)};
    if (colorBy.range && !(colorBy.range->low < colorBy.range->high))
        return invalid("range", "the second value must be the greater one");
    colorBy.colorMap = ColorMap::find(message.color_map()).value();
    if (message.of_pixel() == "nearest") colorBy.ofPixel = ColorBy::OfPixel::nearest;
    if (message.of_pixel() == "mean") colorBy.ofPixel = ColorBy::OfPixel::mean;
    return colorBy;
}

proto::ColorBy toProto(const ColorBy& colorBy) {
    proto::ColorBy message;
    message.set_column(colorBy.column);
    if (colorBy.range) {
        message.add_range(colorBy.range->low);
        message.add_range(colorBy.range->high);
    }
    message.set_color_map(std::string(colorBy.colorMap.name()));
    if (colorBy.ofPixel)
        message.set_of_pixel(*colorBy.ofPixel == ColorBy::OfPixel::mean ? "mean" : "nearest");
    return message;
}

void visitFields(ColorBy& colorBy, const ColorBy& other, FieldVisitor& visitor) {
    visitor.word(colorBy.column == other.column && colorBy.colorMap == other.colorMap &&
                 colorBy.ofPixel == other.ofPixel);
    visitor.word(colorBy.range.has_value() == other.range.has_value());
    if (!colorBy.range || !other.range) return;
    visitor.number(colorBy.range->low, other.range->low);
    visitor.number(colorBy.range->high, other.range->high);
}

}  // namespace mote
