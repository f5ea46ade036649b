// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the mouse does to a camera. Pure functions; distances on the screen are fractions of the picture's
// height, so that the same gesture does the same at any size.
#pragma once

#include <glm/vec2.hpp>
#include <optional>

#include "protocol/scene/bounds.h"
#include "protocol/scene/camera.h"

namespace mote::client {

/// Turns eye and target around a place, whose place on the screen stays: one height of the picture is half a
/// turn. The poles are not crossed.
Camera orbit(const Camera& camera, glm::dvec2 drag, const glm::dvec3& about);

/// Turns the picture about its middle, counterclockwise.
Camera roll(const Camera& camera, double radians);

/// Moves eye and target with the mouse, so that the target's plane sticks to it.
Camera pan(const Camera& camera, glm::dvec2 drag);

/// Goes to a place, whose place on the screen stays: each unit of `steps` a tenth of the way. An orthographic
/// camera, which has no distance, narrows its height instead.
Camera dolly(const Camera& camera, double steps, const glm::dvec3& to);

/// A line of sight.
struct Sight {
    glm::dvec3 from, along;  ///< `along` has length 1 in depth
};

/// That of a place of the picture, parts of its width and height, y down.
Sight sightAt(const Camera& camera, double aspect, glm::dvec2 at);
/// Where in the picture a place is seen; nothing of one that does not lie before the eye.
std::optional<glm::dvec2> seenAt(const Camera& camera, double aspect, const glm::dvec3& place);

/// The place in the target's plane, or in the middle of what of the line of sight lies in the box, that is
/// seen at a place of the picture, parts of its width and height, y down. Nothing where the line misses the
/// box.
glm::dvec3 placeAt(const Camera& camera, double aspect, glm::dvec2 at);
std::optional<glm::dvec3> placeWithin(const Camera& camera, double aspect, glm::dvec2 at, const Bounds& box);

/// Narrows the angle (or the height) and leaves the eye where it is.
Camera zoom(const Camera& camera, double steps);

/// The eye as far from the target as before, on the side of axis 0 to 2 that is `positive`; z is up, from
/// above and below y.
Camera lookFrom(const Camera& camera, int axis, bool positive);

/// The same direction and projection as `camera`, as far away and from around the place that `fitted` has.
Camera fitAlong(const Camera& camera, const Camera& fitted);

/// The other projection, with the target's plane at the same size.
Camera toggleProjection(const Camera& camera);

}  // namespace mote::client
