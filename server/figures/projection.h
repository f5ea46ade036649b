// SPDX-License-Identifier: GPL-3.0-or-later
//
// Projection: where a camera's picture shows a place, as docs/PICTURE.md defines it. A value; pure.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "protocol/scene/view.h"

namespace mote::server {

class Projection {
  public:
    explicit Projection(const View& view);

    bool perspective() const { return perspective_; }
    const glm::dmat4& worldToEye() const { return worldToEye_; }
    /// Depths below it are not seen.
    double nearDepth() const { return near_; }
    /// Pixels, of a place in eye space that is seen by its depth.
    glm::dvec2 pixel(const glm::dvec3& inEye) const;
    /// World units across a pixel at a depth.
    double pixelSize(double depth) const;

  private:
    glm::dmat4 worldToEye_;
    glm::dvec2 size_;  // of the picture, pixels
    double halfHeight_;
    bool perspective_;
    double near_;
};

}  // namespace mote::server
