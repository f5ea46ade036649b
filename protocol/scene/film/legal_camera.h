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

/// The nearest camera that a view may have, of one whose `up` is away from its line of sight: where the
/// digits would not tell the eye from the target it stands a little farther off; what is too far away, too
/// narrow or too low is brought to the limit.
Camera held(Camera camera);

/// Lets a camera look at a target from a distance in an orientation; held within the limits.
Camera standing(Camera camera, const glm::dvec3& target, const glm::dquat& orientation, double distance);

}  // namespace mote
