// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/write_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/matrix.hpp>

#include "protocol/base/check.h"
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

Result<glm::dmat4> parseTransform(const google::protobuf::RepeatedField<double>& rows, double mostScale) {
    if (rows.empty()) return glm::dmat4(1.0);
    if (rows.size() != 16)
        return invalid("transform", fmt::format("16 numbers are needed, not {}", rows.size()));
    glm::dmat4 transform(1.0);
    for (int i = 0; i < 16; ++i) {
        MOTE_RETURN_IF_ERROR(checkRange(rows[i], -1e3 * mostScale, 1e3 * mostScale, ""),
                             fmt::format("transform[{}]", i));
        transform[i % 4][i / 4] = rows[i];  // glm keeps columns
    }
    if (rows[12] != 0.0 || rows[13] != 0.0 || rows[14] != 0.0 || rows[15] != 1.0)
        return invalid("transform", "the last row must be 0, 0, 0, 1");
    const double determinant = std::abs(glm::determinant(glm::dmat3(transform)));
    if (!(std::cbrt(determinant) > 1.0 / mostScale && std::cbrt(determinant) < mostScale))
        return invalid("transform", "the matrix must be invertible and of sensible scale");
    return transform;
}

void writeTransform(const glm::dmat4& transform, google::protobuf::RepeatedField<double>* rows) {
    if (transform == glm::dmat4(1.0)) return;
    for (int i = 0; i < 16; ++i) rows->Add(transform[i % 4][i / 4]);
}

Light lightOf(const proto::Light& message) {
    return {.direction = readVector(message.direction()),
            .fixed = message.fixed(),
            .ambient = message.ambient(),
            .diffuse = message.diffuse(),
            .specular = message.specular(),
            .shadow = message.shadow()};
}

}  // namespace mote
