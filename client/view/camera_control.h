// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the mouse does to a camera. Pure functions; distances on the screen are fractions of the picture's
// height, so that the same gesture does the same at any size.
#pragma once

#include <glm/vec2.hpp>

#include "protocol/scene/camera.h"

namespace mote::client {

/// Turns the eye around the target: one height of the picture is half a turn. The poles are not crossed.
Camera orbit(const Camera& camera, glm::dvec2 drag);

/// Moves eye and target with the mouse, so that the target's plane sticks to it.
Camera pan(const Camera& camera, glm::dvec2 drag);

/// Moves the eye towards the target: each unit of `steps` goes a tenth of the way. An orthographic camera,
/// which has no distance, narrows its height instead.
Camera dolly(const Camera& camera, double steps);

/// Narrows the angle (or the height) and leaves the eye where it is.
Camera zoom(const Camera& camera, double steps);

/// The eye as far from the target as before, on the side of axis 0 to 2 that is `positive`; z is up, from
/// above and below y.
Camera lookFrom(const Camera& camera, int axis, bool positive);

/// The other projection, with the target's plane at the same size.
Camera toggleProjection(const Camera& camera);

}  // namespace mote::client
