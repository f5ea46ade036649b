// SPDX-License-Identifier: GPL-3.0-or-later
//
// Fields of messages, read, and written so that the same is read again. Pure functions.
#pragma once

#include <google/protobuf/repeated_field.h>

#include <glm/vec3.hpp>

#include "protocol/mote.pb.h"
#include "protocol/scene/light.h"

namespace mote {

/// Three numbers that a resolved message has.
glm::dvec3 readVector(const google::protobuf::RepeatedField<double>& field);
/// A colour that it has, linear RGB.
glm::dvec3 readColor(const google::protobuf::RepeatedField<double>& field);

void writeVector(const glm::dvec3& vector, google::protobuf::RepeatedField<double>* field);

/// A linear colour, sRGB-encoded. Returns what the reader will make of it, which may differ in the last
/// digits.
glm::dvec3 writeColor(const glm::dvec3& color, google::protobuf::RepeatedField<double>* field);

proto::Light toProto(const Light& light);

}  // namespace mote
