// SPDX-License-Identifier: GPL-3.0-or-later
//
// Outlines of what is at least a level in a picture, by marching squares (Lorensen and Cline 1987, in the
// plane; Maple 2003, Geometric design and space planning using the marching squares and marching cube
// algorithms). Pure.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <stop_token>
#include <vector>

#include "server/render/ink/raster.h"

namespace mote::render {

/// Closed: the last point is followed by the first. What is inside lies on its right as it is drawn on the
/// screen, so it goes around a region clockwise and around a hole in one the other way.
struct Outline {
    std::vector<glm::dvec2> points;  ///< pixels from the picture's upper left corner; at least three
    std::uint32_t region = 0;  ///< connected pixels that it bounds, alike in their outer outline and holes
};

/// The outlines of values at the pixels' middles, between which they are linear along rows and columns; what
/// lies beside the picture is outside, and its sides are the outline there. In a square whose corners are
/// inside by turns those are connected where the mean of the four is inside, so outlines never cross. A value
/// that is no number is outside. Points that lie within a 32nd of a pixel of the way between others are left
/// out, and so is an outline of fewer than three others. In the order of regions, those by their first
/// pixels. Nothing if `stop` is requested meanwhile.
std::vector<Outline> contoursOf(const Raster<float>& values, float level, const std::stop_token& stop);

/// Square pixels, as the sum of a region's outlines has them: less than 0 of a hole.
double signedArea(const Outline& outline);

}  // namespace mote::render
