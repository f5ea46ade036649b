// SPDX-License-Identifier: GPL-3.0-or-later
//
// The edges of a box in a picture: which are outermost and which lie in front or behind. Values, pure
// functions.
#pragma once

#include <array>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "server/figures/marks.h"
#include "server/figures/projection.h"

namespace mote::server {

struct BoxEdge {
    enum class Kind {
        outline,  ///< between a side that is seen and one that is not: nothing lies outside of it
        front,    ///< between two sides that are seen
        back,     ///< between two that are not
    };
    int axis = 0;          ///< along which it goes
    glm::dvec3 low, high;  ///< its ends, eye space
    Kind kind = Kind::back;
    double from = 0.0, to = 1.0;  ///< the share of it that is in the picture; none if from >= to

    glm::dvec3 at(double share) const { return low + share * (high - low); }
};

struct BoxInPicture {
    std::array<BoxEdge, 12> edges;
    glm::dvec2 middle;      ///< of the outline's corners, pixels
    bool outlined = false;  ///< there is an outline: the eye is outside, and nothing is too near
};

/// The box [-1, 1]^3 of a layer.
BoxInPicture boxInPicture(const glm::dmat4& layerToEye, const Projection& projection, const Box& picture);

}  // namespace mote::server
