// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/hybrid/hybrid_plan.h"

#include <glm/geometric.hpp>
#include <utility>

namespace mote::render {
namespace {

/// A half-space of layer space, in the box.
HalfSpace inBox(const HalfSpace& layer, const glm::dmat4& boxToLayer) {
    return {glm::transpose(glm::dmat3(boxToLayer)) * layer.normal,
            layer.distance - glm::dot(layer.normal, glm::dvec3(boxToLayer[3]))};
}

std::vector<HalfSpace> clipsOf(const HybridStyle& style, const glm::dmat4& boxToLayer) {
    std::vector<HalfSpace> clips;
    for (const auto& plane : style.clipPlanes) clips.push_back(inBox(plane, boxToLayer));
    if (!style.clipBox) return clips;
    for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 normal(0.0);
        normal[axis] = 1.0;
        clips.push_back(inBox({normal, style.clipBox->min[axis]}, boxToLayer));
        clips.push_back(inBox({-normal, -style.clipBox->max[axis]}, boxToLayer));
    }
    return clips;
}

}  // namespace

double HybridPlan::layerLength(const glm::dvec3& inBox) const {
    return glm::length(glm::dmat3(step->boxToLayer) * inBox);
}

HybridPlan planHybrid(const HybridStyle& style, const glm::dmat4& layerToWorld,
                      std::shared_ptr<const HybridStep> step, const Camera& camera) {
    const glm::dmat4 worldToEye = camera.worldToEye();
    const glm::dmat4 layerToEye = worldToEye * layerToWorld;
    HybridPlan plan{.step = step,
                    .representation = resolved(style.representation, *step),
                    .boxToEye = layerToEye * step->boxToLayer,
                    .layerToWorld = layerToWorld,
                    .style = style,
                    .transfer = HybridTransfer(style, *step),
                    .light = HybridLight(style.light, layerToEye, worldToEye),
                    .clips = clipsOf(style, step->boxToLayer)};
    return plan;
}

}  // namespace mote::render
