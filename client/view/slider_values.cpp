// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/slider_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "protocol/scene/srgb.h"

namespace mote::client {

LightAngles LightAngles::of(const glm::dvec3& direction) {
    const glm::dvec3 unit = glm::normalize(direction);
    return {static_cast<float>(glm::degrees(std::atan2(unit.x, unit.z))),
            static_cast<float>(glm::degrees(std::asin(std::clamp(unit.y, -1.0, 1.0))))};
}

glm::dvec3 LightAngles::direction() const {
    const double right = glm::radians(static_cast<double>(across));
    const double up = glm::radians(static_cast<double>(above));
    return {std::cos(up) * std::sin(right), std::sin(up), std::cos(up) * std::cos(right)};
}

std::array<float, 3> toFloats(const glm::dvec3& vector) {
    return {static_cast<float>(vector.x), static_cast<float>(vector.y), static_cast<float>(vector.z)};
}

glm::dvec3 toVector(const std::array<float, 3>& numbers) {
    return {numbers[0], numbers[1], numbers[2]};
}

double decimal(float value) {
    const auto text = fmt::format("{}", value);  // the shortest that gives this float again
    double number = static_cast<double>(value);
    std::from_chars(text.data(), text.data() + text.size(), number);
    return number;
}

double share(float value) {
    return std::clamp(decimal(value), 0.0, 1.0);
}

std::array<float, 3> shownColor(const google::protobuf::RepeatedField<double>& said,
                                const glm::dvec3& drawn) {
    return toFloats(said.size() == 3 ? glm::dvec3(said[0], said[1], said[2]) : linearToSrgb(drawn));
}

void assign(google::protobuf::RepeatedField<double>* field, const glm::dvec3& vector) {
    field->Clear();
    for (int i = 0; i < 3; ++i) field->Add(vector[i]);
}

void assignColor(google::protobuf::RepeatedField<double>* field, const std::array<float, 3>& color) {
    field->Clear();
    for (const float value : color) field->Add(share(value));
}

}  // namespace mote::client
