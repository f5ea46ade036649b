// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is seen of a dot on a page: all of it in one colour, pieces of it where what lies before it differs
// from pixel to pixel, or nothing. Pure functions.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "server/encode/vector/shape_places.h"
#include "server/encode/vector/sight.h"
#include "server/render/plan/dot.h"

namespace mote::server {

struct SeenDot {
    glm::vec3 color{0.0F};            ///< linear RGB, with what lies before it
    std::vector<glm::dvec2> outline;  ///< pixels from the dot's centre, closed; empty: the whole dot
};

/// In the rows of the picture. `plotter`: a pen has one colour and draws a dot or none: that of which half
/// comes through.
std::vector<SeenDot> seenOf(const render::Dot& dot, const Sight& sight, const PictureSize& size,
                            bool plotter);

}  // namespace mote::server
