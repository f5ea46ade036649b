// SPDX-License-Identifier: GPL-3.0-or-later
//
// HybridPlan: what a device is to draw of one hybrid layer: its step, its transfer functions and light, and
// where it is cut. A value that shares its step; part of a FramePlan.
#pragma once

#include <glm/mat4x4.hpp>
#include <memory>
#include <vector>

#include "protocol/scene/view.h"
#include "server/render/layers/hybrid/hybrid_light.h"
#include "server/render/layers/hybrid/hybrid_step.h"
#include "server/render/layers/hybrid/hybrid_transfer.h"

namespace mote::render {

struct HybridPlan {
    std::shared_ptr<const HybridStep> step;
    HybridRepresentation representation;  ///< never `best`; the step has what it takes
    glm::dmat4 boxToEye{1.0};             ///< the volume's box [0, 1]^3 to eye space
    glm::dmat4 layerToWorld{1.0};         ///< Layer::transform
    HybridStyle style;                    ///< for what points do
    HybridTransfer transfer;
    HybridLight light;
    /// In the box: what lies in all of them is drawn. Their normals are of any length.
    std::vector<HalfSpace> clips;

    /// How much of the bricks' correction is applied, 0 to 1.
    double correction() const {
        return representation == HybridRepresentation::points ? style.pointOpacity : 1.0;
    }
    /// Of the weights by which neighbouring samples of a brick are mixed, half way between them.
    double steepness() const {
        return representation == HybridRepresentation::points ? style.pointSteepness() : 1.0;
    }
    bool corrected() const {
        return representation != HybridRepresentation::volume && step->bricks && correction() > 0.0;
    }
    /// Whether the low volume shows in bricks, too.
    bool mixed() const { return corrected() && correction() < 1.0; }
    /// How far it is in layer space from one place in the box to another.
    double layerLength(const glm::dvec3& inBox) const;
};

HybridPlan planHybrid(const HybridStyle& style, const glm::dmat4& layerToWorld,
                      std::shared_ptr<const HybridStep> step, const Camera& camera);

}  // namespace mote::render
