// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/stipple/stipple_surface.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace mote::render {

StippleSurface::StippleSurface(StippleReplay replay, SurfaceRays rays, const Bounds& bounds, double area)
    : replay_(std::move(replay)),
      rays_(std::move(rays)),
      bounds_(bounds),
      density_(static_cast<double>(replay_.size()) / area),
      tolerance_(static_cast<float>(0.05 / std::sqrt(std::max(density_, 1e-30)))) {}

bool StippleSurface::hides(const glm::vec3& place, const glm::vec3& normal, const glm::vec3& direction,
                           float reach) const {
    // Rays start off the surface, on the side from which it is looked at.
    const float side = glm::dot(normal, direction) < 0.0F ? -tolerance_ : tolerance_;
    return rays_.blocked(place + side * normal, direction, reach);
}

}  // namespace mote::render
