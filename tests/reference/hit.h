// SPDX-License-Identifier: GPL-3.0-or-later
//
// Hit: what stands at a depth of its own in a pixel, and hides some of what lies behind it. A value.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "protocol/scene/view.h"

namespace mote::reference {

struct Hit {
    std::uint32_t column;
    double depth;      ///< world units along the line of sight
    double alpha;      ///< opacity times coverage, > 0
    glm::dvec3 color;  ///< linear RGB
};

/// The nearest depth that is seen: nothing nearer, in points or volume. Minus infinity for an orthographic
/// camera.
double nearestDepth(const Camera& camera);

/// Whether a layer's clips cut a place of layer space away (docs/PICTURE.md, "Clipping").
bool cutAway(const Layer& layer, const glm::dvec3& place);

}  // namespace mote::reference
