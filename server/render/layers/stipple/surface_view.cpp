// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/stipple/surface_view.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>

#include "server/render/plan/frame_plan.h"

namespace mote::render {

SurfaceView::SurfaceView(const View& view, const glm::dmat4& transform)
    : layerToEye(view.camera.worldToEye() * transform),
      turnToEye(view.camera.worldToEye()),
      size(view.width, view.height),
      pixels(view.height / (2.0 * view.camera.halfHeight())),
      perspective(view.camera.perspective()),
      nearest(perspective ? nearShare * glm::length(view.camera.target - view.camera.eye)
                          : -std::numeric_limits<double>::infinity()) {
    const glm::dmat3 linear(layerToEye);
    // The cofactors; a mirror image keeps outside out.
    areaToEye = std::abs(glm::determinant(linear)) * glm::transpose(glm::inverse(linear));
}

glm::dvec3 SurfaceView::towardsEye(const glm::dvec3& inEye) const {
    return perspective ? -glm::normalize(inEye) : glm::dvec3(0.0, 0.0, 1.0);
}

glm::dvec2 SurfaceView::onScreen(const glm::dvec3& inEye) const {
    const double scale = perspective ? pixels / -inEye.z : pixels;
    return 0.5 * size + scale * glm::dvec2(inEye.x, -inEye.y);
}

double SurfaceView::pixelArea(const glm::dvec3& inEye, const glm::dvec3& area) const {
    if (!perspective) return pixels * pixels * std::abs(area.z);
    // The Jacobian of the projection x / z, y / z, along the surface.
    return pixels * pixels * std::abs(glm::dot(area, inEye) / (inEye.z * inEye.z * inEye.z));
}

}  // namespace mote::render
