// SPDX-License-Identifier: GPL-3.0-or-later
//
// Places in a plane as a message holds them: a list of pairs of numbers, [[x, y], ...] in JSON. Pure
// functions.
#pragma once

#include <google/protobuf/struct.pb.h>

#include <cstddef>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "protocol/scene/error.h"

namespace mote {

using PointListMessage = google::protobuf::RepeatedPtrField<google::protobuf::ListValue>;

/// At least `least` and at most `most` pairs of finite numbers of magnitude up to `limit`. Errors at
/// "points", "points[3]" (not a pair) or "points[3][1]".
Result<std::vector<glm::dvec2>> parsePoints(const PointListMessage& points, std::size_t least,
                                            std::size_t most, double limit);

void writePoints(std::span<const glm::dvec2> points, PointListMessage* message);

}  // namespace mote
