// SPDX-License-Identifier: GPL-3.0-or-later
//
// Fields made in memory for tests of what ink sees of them. Pure.
#pragma once

#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "server/render/layers/ink/ink_data.h"
#include "server/render/plan/frame_plan.h"
#include "tests/support/hybrid_scene.h"

namespace mote::test {

/// [0, 1]^3 to [-1, 1]^3.
inline HybridShape cubeShape(std::uint32_t samples) {
    return {.source = glm::uvec3(samples), .low = glm::uvec3(samples), .boxToLayer = render::plotToLayer()};
}

/// `opacity` of values, over a length in layer units.
inline render::InkVolume inkVolume(const HybridShape& shape, std::vector<Curve::Knot> opacity, double length,
                                   const std::function<double(const glm::dvec3&)>& inLayer) {
    auto field = hybridOf(shape, [&](const glm::dvec3& inBox) {
        return inLayer(glm::dvec3(shape.boxToLayer * glm::dvec4(inBox, 1.0)));
    });
    return {std::move(field),
            {.opacity = Curve::create(std::move(opacity)).value(), .opacityLength = length}};
}

/// Along -z, with the middle in the middle; a pixel is 2 / pixels units.
inline Camera ahead(double height) {
    return {.eye = {0.0, 0.0, 5.0}, .target = glm::dvec3(0.0), .orthographicHeight = height};
}

/// A ball around the middle, opaque within a hundredth of its surface.
inline render::InkVolume ball(std::uint32_t samples, double radius,
                              const glm::dvec3& middle = {0.0, 0.0, 0.0}) {
    return inkVolume(cubeShape(samples), {{0.5, 0.0}, {0.51, 0.99}}, 0.01, [=](const glm::dvec3& at) {
        return std::clamp(0.5 + 0.5 * (radius - glm::length(at - middle)), 0.0, 1.0);
    });
}

}  // namespace mote::test
