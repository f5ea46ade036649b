// SPDX-License-Identifier: GPL-3.0-or-later
//
// The points that a plane hierarchy starts from: random ones, one in each of as many equal boxes, made even
// by Lloyd's method with over-relaxation. Functions without state.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <vector>

#include "preprocess/progress.h"
#include "protocol/scene/error.h"

namespace mote::prep {

/// Points on the unit square, neighbours in the list near each other. At least one.
std::vector<glm::dvec2> stratifiedPoints(std::uint32_t points, std::uint64_t seed);

/// One step of Lloyd's method on the periodic square, each point going `relaxation` times the way to its
/// cell's centroid. The same on any number of threads.
std::vector<glm::dvec2> relaxOnce(const std::vector<glm::dvec2>& points, double relaxation);

/// stratifiedPoints, relaxed until they are as even as after 50 steps of Lloyd's method or more. Reports
/// progress from 0 to `share`. Errors: cancelled.
Result<std::vector<glm::dvec2>> evenPoints(std::uint32_t points, std::uint64_t seed, double share,
                                           Progress& progress);

}  // namespace mote::prep
