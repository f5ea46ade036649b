// SPDX-License-Identifier: GPL-3.0-or-later
//
// Closed paths cut to rectangles (Sutherland and Hodgman 1974). Pure functions.
#pragma once

#include <glm/vec2.hpp>
#include <span>
#include <vector>

namespace mote::server {

struct ClipBox {
    glm::dvec2 low{0.0}, high{0.0};
};

/// What of a closed path lies in a box; where it would fall apart, its parts are joined along the box's
/// edges, which changes nothing of what it fills. Empty where nothing does.
std::vector<glm::dvec2> clipped(std::span<const glm::dvec2> path, const ClipBox& box);

/// A disc around the origin, of the same area.
std::vector<glm::dvec2> discPath(double radius);

}  // namespace mote::server
