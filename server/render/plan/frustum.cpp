// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/frustum.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace mote::render {

Frustum::Frustum(const Camera& camera, double width, double height, double marginPixels, double nearDepth,
                 const glm::dmat4& layerToEye) {
    const double y = camera.halfHeight() * (1.0 + 2.0 * marginPixels / height);
    const double x = camera.halfHeight() * width / height * (1.0 + 2.0 * marginPixels / width);
    // In eye space, where depth is -z: |ex| <= x * depth (perspective) or |ex| <= x (orthographic).
    const auto side = [&](double sx, double sy, double half) {
        return camera.perspective() ? glm::dvec4(sx, sy, -half, 0.0) : glm::dvec4(sx, sy, 0.0, half);
    };
    const std::array<glm::dvec4, 5> eyePlanes{side(1.0, 0.0, x), side(-1.0, 0.0, x), side(0.0, 1.0, y),
                                              side(0.0, -1.0, y), glm::dvec4(0.0, 0.0, -1.0, -nearDepth)};
    planeCount_ = camera.perspective() ? 5 : 4;
    const glm::dmat4 toLayer = glm::transpose(layerToEye);
    for (std::size_t i = 0; i < planeCount_; ++i) {
        const glm::dvec4 equation = toLayer * eyePlanes[i];
        planes_[i] = {equation, std::abs(equation.x) + std::abs(equation.y) + std::abs(equation.z)};
    }
}

Frustum::Side Frustum::of(const glm::dvec3& center, double halfEdge) const {
    // Rounding must not hide a point that lies on the border: widen by a trillionth of the numbers involved.
    constexpr double rounding = 1e-12;
    Side side = Side::inside;
    for (std::size_t i = 0; i < planeCount_; ++i) {
        const auto& [equation, reach] = planes_[i];
        const double distance = glm::dot(glm::dvec3(equation), center) + equation.w;
        const double margin = reach * halfEdge + rounding * (reach + std::abs(equation.w));
        if (distance < -margin) return Side::outside;
        if (distance < margin) side = Side::partly;
    }
    return side;
}

}  // namespace mote::render
