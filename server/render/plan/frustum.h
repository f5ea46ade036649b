// SPDX-License-Identifier: GPL-3.0-or-later
//
// A Frustum is the part of a layer's space in which a point can touch the picture. A value.
#pragma once

#include <array>
#include <cstddef>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "protocol/scene/camera.h"

namespace mote::render {

class Frustum {
  public:
    enum class Side { outside, partly, inside };

    /// `marginPixels`: how far a point's footprint reaches from its centre; `nearDepth`: what lies nearer is
    /// unseen by a perspective camera.
    Frustum(const Camera& camera, double width, double height, double marginPixels, double nearDepth,
            const glm::dmat4& layerToEye);

    /// Where the cube around `center` lies, layer space; never `outside` where a point in it is seen.
    Side of(const glm::dvec3& center, double halfEdge) const;

  private:
    struct Plane {
        glm::dvec4 equation;  ///< positive on the seen side, layer space
        double reach;  ///< |x| + |y| + |z| of its normal: how much a cube of half edge 1 reaches across
    };
    std::array<Plane, 5> planes_{};
    std::size_t planeCount_ = 0;
};

}  // namespace mote::render
