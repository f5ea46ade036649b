// SPDX-License-Identifier: GPL-3.0-or-later
//
// Fields of messages, read, and written so that the same is read again. Pure functions.
#pragma once

#include <google/protobuf/repeated_field.h>

#include <algorithm>
#include <array>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <string_view>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/light.h"

namespace mote {

/// Three numbers that a resolved message has.
glm::dvec3 readVector(const google::protobuf::RepeatedField<double>& field);
/// A colour that it has, linear RGB.
glm::dvec3 readColor(const google::protobuf::RepeatedField<double>& field);

/// The value of an enumeration whose words stand in its order, by one of them.
template <class Enum, std::size_t count>
Enum enumOf(std::string_view word, const std::array<std::string_view, count>& words) {
    return static_cast<Enum>(std::find(words.begin(), words.end(), word) - words.begin());
}

void writeVector(const glm::dvec3& vector, google::protobuf::RepeatedField<double>* field);

/// A linear colour, sRGB-encoded. Returns what the reader will make of it, which may differ in the last
/// digits.
glm::dvec3 writeColor(const glm::dvec3& color, google::protobuf::RepeatedField<double>* field);

proto::Light toProto(const Light& light);

/// Errors, at "transform": not 16 finite numbers, not affine, not invertible, of a scale (the cube root of
/// the determinant) that is not below `mostScale` and above 1 over it.
Result<glm::dmat4> parseTransform(const google::protobuf::RepeatedField<double>& rows,
                                  double mostScale = 1e6);

/// Nothing for the identity.
void writeTransform(const glm::dmat4& transform, google::protobuf::RepeatedField<double>* rows);

}  // namespace mote
