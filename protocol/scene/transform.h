// SPDX-License-Identifier: GPL-3.0-or-later
//
// The affine transform of a layer as a message gives it: 16 numbers, row by row; none: the identity. Pure
// functions.
#pragma once

#include <google/protobuf/repeated_field.h>

#include <glm/mat4x4.hpp>

#include "protocol/scene/error.h"

namespace mote {

/// Errors, at "transform": not 16 finite numbers, not affine, not invertible.
Result<glm::dmat4> parseTransform(const google::protobuf::RepeatedField<double>& rows);

/// Nothing for the identity.
void writeTransform(const glm::dmat4& transform, google::protobuf::RepeatedField<double>* rows);

}  // namespace mote
