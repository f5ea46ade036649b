// SPDX-License-Identifier: GPL-3.0-or-later
//
// BoxSpace: how a layer's volume fills its box [0, 1]^3, as rays go through it. A value that points to what
// its plan keeps.
#pragma once

#include <glm/mat3x3.hpp>
#include <span>

#include "protocol/scene/hybrid_style.h"

namespace mote::render {

struct BoxSpace {
    glm::dvec3 cells{1.0};    ///< along each axis
    double shift = 0.0;       ///< the place of the box's first corner, in cells, on each axis
    double samples = 1.0;     ///< segments a cell's edge
    glm::dmat3 toLayer{2.0};  ///< box to layer space, without its place; a plot's box is [-1, 1]^3 there
    std::span<const HalfSpace> clips = {};  ///< in the box: nothing is seen outside of any
};

}  // namespace mote::render
