// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/write_fields.h"

#include <algorithm>
#include <cmath>

#include "protocol/scene/srgb.h"

namespace mote {
namespace {

/// What srgbToLinear() gives the value for. Its two branches do not meet to the last digits: whichever comes
/// closer.
double encoded(double linear) {
    const double low = std::clamp(12.92 * linear, 0.0, 1.0),
                 high = std::clamp(linearToSrgb(linear), 0.0, 1.0);
    return std::abs(srgbToLinear(low) - linear) <= std::abs(srgbToLinear(high) - linear) ? low : high;
}

}  // namespace

glm::dvec3 readVector(const google::protobuf::RepeatedField<double>& field) {
    return {field[0], field[1], field[2]};
}

glm::dvec3 readColor(const google::protobuf::RepeatedField<double>& field) {
    return srgbToLinear(readVector(field));
}

void writeVector(const glm::dvec3& vector, google::protobuf::RepeatedField<double>* field) {
    field->Assign(&vector.x, &vector.x + 3);
}

glm::dvec3 writeColor(const glm::dvec3& color, google::protobuf::RepeatedField<double>* field) {
    const glm::dvec3 written(encoded(color.x), encoded(color.y), encoded(color.z));
    writeVector(written, field);
    return srgbToLinear(written);
}

proto::Light toProto(const Light& light) {
    proto::Light message;
    writeVector(light.direction, message.mutable_direction());
    message.set_fixed(light.fixed);
    message.set_ambient(light.ambient);
    message.set_diffuse(light.diffuse);
    message.set_specular(light.specular);
    message.set_shadow(light.shadow);
    return message;
}

}  // namespace mote
