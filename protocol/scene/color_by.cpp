// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/color_by.h"

#include <fmt/format.h>

#include "protocol/scene/check.h"
#include "protocol/scene/column_name.h"

namespace mote {
namespace {

constexpr double largestColored = 1e300;  // so that the length of a range is a number

Result<std::optional<ValueRange>> parseRange(const google::protobuf::RepeatedField<double>& range) {
    if (range.empty()) return std::optional<ValueRange>();
    if (range.size() != 2) return invalid("range", fmt::format("2 values are needed, not {}", range.size()));
    MOTE_ASSIGN_OR_RETURN(const auto low, checkRange(range[0], -largestColored, largestColored, "range[0]"));
    MOTE_ASSIGN_OR_RETURN(const auto high, checkRange(range[1], -largestColored, largestColored, "range[1]"));
    if (!(low < high)) return invalid("range", "the second value must be the greater one");
    return std::optional(ValueRange{low, high});
}

}  // namespace

Result<ColorBy> parseColorBy(const proto::ColorBy& message) {
    ColorBy colorBy;
    MOTE_ASSIGN_OR_RETURN(colorBy.column, checkColumnName(message.column(), "column"));
    MOTE_ASSIGN_OR_RETURN(colorBy.range, parseRange(message.range()));
    const auto& map = message.color_map();
    const auto found = ColorMap::find(map.empty() ? ColorBy::defaultMap : std::string_view(map));
    if (!found.ok()) return found.error().within("colorMap");
    colorBy.colorMap = *found;
    const auto& word = message.of_pixel();
    if (word == "nearest") colorBy.ofPixel = ColorBy::OfPixel::nearest;
    if (word == "mean") colorBy.ofPixel = ColorBy::OfPixel::mean;
    if (word.empty() || word == "mean" || word == "nearest") return colorBy;
    return invalid("ofPixel", "there are \"mean\" and \"nearest\"");
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
