// SPDX-License-Identifier: GPL-3.0-or-later
//
// The plane in which clips cut what lies on the screen: images and stippled pictures (docs/PICTURE.md,
// "Clipping"). A pure function.
#pragma once

#include <algorithm>
#include <glm/vec3.hpp>

namespace mote {

/// Where a pixel lies: x to the right and y up from the middle of a picture of width x height pixels, its
/// longer side from -1 to 1; z is 0. `x`, `y`: pixels from its upper left corner.
inline glm::dvec3 placeInPicture(double x, double y, double width, double height) {
    const double longer = std::max(width, height);
    return {(2.0 * x - width) / longer, (height - 2.0 * y) / longer, 0.0};
}

}  // namespace mote
