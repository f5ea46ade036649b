// SPDX-License-Identifier: GPL-3.0-or-later
//
// Range checks for fields of messages: each returns the value, or an Error that names the field. Pure
// functions.
#pragma once

#include <google/protobuf/repeated_field.h>

#include <glm/vec3.hpp>
#include <string>
#include <string_view>

#include "protocol/base/error.h"

namespace mote {

/// A finite number in [least, greatest].
Result<double> checkRange(double value, double least, double greatest, std::string_view field);

/// Three finite numbers, each of magnitude at most `limit`.
Result<glm::dvec3> checkVector(const google::protobuf::RepeatedField<double>& values, double limit,
                               std::string_view field);

}  // namespace mote
