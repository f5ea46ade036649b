// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/reference/point_splat.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <numbers>

#include "server/render/hybrid/hybrid_transfer.h"
#include "tests/reference/hybrid_field.h"

namespace mote::reference {
namespace {

bool inAll(const std::vector<HalfSpace>& sides, const glm::dvec3& place) {
    return std::all_of(sides.begin(), sides.end(),
                       [&](const HalfSpace& side) { return glm::dot(side.normal, place) >= side.distance; });
}

}  // namespace

double PointSplat::reach() const {
    if (shape == PointShape::square) return std::ceil(size);
    if (shape == PointShape::gaussian) return 1.5 * std::max(size, 1.0);
    const double area = size * size / std::numbers::pi;  // radius squared
    return std::sqrt(std::max(area, 1.0 / 3.0) - 1.0 / 12.0) + 0.5;
}

double PointSplat::coverage(double dx, double dy) const {
    const double distance = std::hypot(dx, dy);
    switch (shape) {
        case PointShape::square: {
            const double half = 0.5 * reach();
            // The centre lies in [x - s/2, x + s/2).
            const bool met = dx >= -half && dx < half && dy >= -half && dy < half;
            return met ? std::min(1.0, std::pow(spacing / reach(), 2.0)) : 0.0;
        }
        case PointShape::disc: {
            const double most = std::min(1.0, 3.0 * size * size / std::numbers::pi);
            return std::min(1.0, std::pow(spacing / size, 2.0)) * most *
                   std::clamp(reach() - distance, 0.0, 1.0);
        }
        case PointShape::gaussian:
            break;
    }
    if (distance >= reach()) return 0.0;
    const double variance = std::pow(0.5 * std::max(size, 1.0), 2.0);
    return std::min(1.0, spacing * spacing / (2.0 * std::numbers::pi * variance) *
                             std::exp(-distance * distance / (2.0 * variance)));
}

std::vector<PointSplat> pointSplats(const render::HybridStep& step, const Layer& layer, const View& view) {
    const HybridStyle& style = *layer.hybrid();
    std::vector<PointSplat> splats;
    if (!step.points || render::resolved(style.representation, step) != HybridRepresentation::points)
        return splats;
    const render::HybridTransfer transfer(style, step);
    const auto within = HybridField(step, layer, view.camera).within();
    const glm::dmat4 layerToEye = view.camera.worldToEye() * layer.transform;
    const glm::dvec3 size(step.points->size);
    const double cell =
        std::cbrt(std::abs(glm::determinant(glm::dmat3(step.boxToLayer))) / (size.x * size.y * size.z));
    const double scale = std::cbrt(std::abs(glm::determinant(glm::dmat3(layerToEye))));
    for (const auto& point : step.points->points) {
        const glm::dvec3 inBox = (glm::dvec3(point.x, point.y, point.z) + 0.5) / size;
        const glm::dvec3 inLayer(step.boxToLayer * glm::dvec4(inBox, 1.0));
        if (!inAll(within, inLayer)) continue;
        const glm::dvec3 inEye(layerToEye * glm::dvec4(inLayer, 1.0));
        const double depth = -inEye.z;
        const double value = step.range.low + point.value / 255.0 * (step.range.high - step.range.low);
        const double error = (point.error - 128) * step.points->errorStep;
        const double lack = std::max(0.0, transfer.extinction(value) - transfer.extinction(value - error));
        const auto shade = shadeOf(point.normal, style.light, layerToEye, view.camera);
        const double halfHeight = view.camera.halfHeight() * (view.camera.perspective() ? depth : 1.0);
        const double pixels = 0.5 * view.height / halfHeight;  // a unit at that depth
        splats.push_back({.x = 0.5 * view.width + inEye.x * pixels,
                          .y = 0.5 * view.height - inEye.y * pixels,
                          .depth = depth,
                          .spacing = cell * scale * pixels,
                          .size = style.pointSize * cell * scale * pixels,
                          .opacity = style.pointOpacity * -std::expm1(-lack * cell),
                          .color = transfer.color(value) * shade.diffuse + shade.specular,
                          .shape = style.pointShape});
    }
    return splats;
}

}  // namespace mote::reference
