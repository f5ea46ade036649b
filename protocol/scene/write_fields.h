// SPDX-License-Identifier: GPL-3.0-or-later
//
// Fields of messages, written so that check.h and light.h read the same again. Pure functions.
#pragma once

#include <google/protobuf/repeated_field.h>

#include <glm/vec3.hpp>

#include "protocol/mote.pb.h"
#include "protocol/scene/light.h"

namespace mote {

void writeVector(const glm::dvec3& vector, google::protobuf::RepeatedField<double>* field);

/// A linear colour, sRGB-encoded. Returns what the reader will make of it, which may differ in the last
/// digits.
glm::dvec3 writeColor(const glm::dvec3& color, google::protobuf::RepeatedField<double>* field);

proto::Light toProto(const Light& light);

}  // namespace mote
