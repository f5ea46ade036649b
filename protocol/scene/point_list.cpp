// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/point_list.h"

#include <fmt/format.h>

#include "protocol/scene/check.h"

namespace mote {
namespace {

bool isNumber(const google::protobuf::Value& value) {
    return value.kind_case() == google::protobuf::Value::kNumberValue;
}

/// The field is named only where there is something to say of it: lists are long.
Result<glm::dvec2> parsePoint(const google::protobuf::ListValue& pair, int index, double limit) {
    if (pair.values_size() != 2 || !isNumber(pair.values(0)) || !isNumber(pair.values(1)))
        return invalid(fmt::format("points[{}]", index), "two numbers are needed");
    glm::dvec2 point(0.0);
    for (int axis = 0; axis < 2; ++axis) {
        const double value = pair.values(axis).number_value();
        if (!(value >= -limit && value <= limit))
            return checkRange(value, -limit, limit, fmt::format("points[{}][{}]", index, axis)).error();
        point[axis] = value;
    }
    return point;
}

}  // namespace

Result<std::vector<glm::dvec2>> parsePoints(const PointListMessage& points, std::size_t least,
                                            std::size_t most, double limit) {
    const auto count = static_cast<std::size_t>(points.size());
    if (count < least) return invalid("points", fmt::format("at least {} are needed, not {}", least, count));
    if (count > most) return invalid("points", fmt::format("there may be at most {}, not {}", most, count));
    std::vector<glm::dvec2> result;
    result.reserve(count);
    for (int i = 0; i < points.size(); ++i) {
        MOTE_ASSIGN_OR_RETURN(const auto point, parsePoint(points[i], i, limit));
        result.push_back(point);
    }
    return result;
}

void writePoints(std::span<const glm::dvec2> points, PointListMessage* message) {
    message->Reserve(static_cast<int>(points.size()));
    for (const auto& point : points) {
        auto& pair = *message->Add();
        pair.add_values()->set_number_value(point.x);
        pair.add_values()->set_number_value(point.y);
    }
}

}  // namespace mote
