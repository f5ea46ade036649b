// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/figures/projection.h"

#include <glm/geometric.hpp>
#include <limits>

#include "protocol/scene/camera.h"

namespace mote::server {

Projection::Projection(const View& view)
    : worldToEye_(view.camera.worldToEye()),
      size_(view.width, view.height),
      halfHeight_(view.camera.halfHeight()),
      perspective_(view.camera.perspective()),
      near_(perspective_ ? nearShare * glm::length(view.camera.target - view.camera.eye)
                         : -std::numeric_limits<double>::infinity()) {}

glm::dvec2 Projection::pixel(const glm::dvec3& inEye) const {
    const glm::dvec2 plane = glm::dvec2(inEye) / (perspective_ ? -inEye.z : 1.0);
    return 0.5 * size_ + glm::dvec2(plane.x, -plane.y) * (0.5 * size_.y / halfHeight_);
}

double Projection::pixelSize(double depth) const {
    return 2.0 * halfHeight_ / size_.y * (perspective_ ? depth : 1.0);
}

}  // namespace mote::server
