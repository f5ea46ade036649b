// SPDX-License-Identifier: GPL-3.0-or-later
//
// Paint: the colour and the opacity with which a page shows something. Pages mix what is not opaque in
// encoded colours, pictures in light: so paint is what gives the picture's colour where it lies on what is
// known to be beneath it. Pure functions.
#pragma once

#include <glm/vec3.hpp>

namespace mote::server {

struct Paint {
    glm::vec3 color{0.0F};  ///< sRGB-encoded
    double opacity = 1.0;
};

/// sRGB-encoded, of linear RGB.
glm::vec3 encoded(const glm::vec3& linear);

/// `color`, `beneath`: linear RGB. No paler than `opacity` and `least`, and less so only where no colour
/// would do.
Paint paintOver(const glm::vec3& color, double opacity, const glm::vec3& beneath, double least = 0.0);

}  // namespace mote::server
