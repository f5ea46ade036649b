// SPDX-License-Identifier: GPL-3.0-or-later
//
// HybridPlan: what a device is to draw of one hybrid layer: its step, its transfer functions and light, and
// where it is cut. A value that shares its step; part of a FramePlan.
#pragma once

#include <glm/mat4x4.hpp>
#include <memory>
#include <vector>

#include "protocol/scene/view.h"
#include "server/render/hybrid/hybrid_light.h"
#include "server/render/hybrid/hybrid_step.h"
#include "server/render/hybrid/hybrid_transfer.h"

namespace mote::render {

struct HybridPlan {
    std::shared_ptr<const HybridStep> step;
    HybridRepresentation representation;  ///< never `best`; the step has what it takes
    glm::dmat4 boxToEye{1.0};             ///< the volume's box [0, 1]^3 to eye space
    HybridStyle style;                    ///< for shape, opacity and size of points
    HybridTransfer transfer;
    HybridLight light;
    /// In the box: what lies in all of them is drawn. Their normals are of any length.
    std::vector<HalfSpace> clips;

    bool corrected() const { return representation == HybridRepresentation::residual && step->bricks; }
    bool hasPoints() const { return representation == HybridRepresentation::points && step->points; }
    /// How far it is in layer space from one place in the box to another.
    double layerLength(const glm::dvec3& inBox) const;
};

/// `layer` must be a hybrid one.
HybridPlan planHybrid(const Layer& layer, std::shared_ptr<const HybridStep> step, const Camera& camera);

}  // namespace mote::render
