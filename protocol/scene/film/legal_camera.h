// SPDX-License-Identifier: GPL-3.0-or-later
//
// Cameras that are computed, held within what a view may have (parseCamera). Pure functions.
#pragma once

#include <glm/gtc/quaternion.hpp>

#include "protocol/scene/camera.h"

namespace mote {

inline constexpr double leastFovYDegrees = 0.1, mostFovYDegrees = 179.0;

/// The rotation from eye space to world space: +z from the target to the eye, +y up.
glm::dquat orientationOf(const Camera& camera);

/// Puts a camera's eye at an offset, not zero, from a target, held within what a view may have: where the
/// digits would not tell the eye from the target it stands a little farther off; what is too far away, too
/// narrow or too low is brought to the limit. `up` is to be away from the offset.
Camera placed(Camera camera, const glm::dvec3& target, const glm::dvec3& offset);

/// Lets a camera look at a target from a distance in an orientation; held within the limits.
Camera standing(Camera camera, const glm::dvec3& target, const glm::dquat& orientation, double distance);

}  // namespace mote
