// SPDX-License-Identifier: GPL-3.0-or-later
//
// HybridPlan: what a device is to draw of one hybrid layer: its step, its transfer functions and light, and
// where it is cut. A value that shares its step; part of a FramePlan.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
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
    glm::dmat4 layerToWorld{1.0};         ///< Layer::transform
    HybridStyle style;                    ///< for shape, opacity and size of points
    /// Of so many points that follow each other one is drawn, for all of them.
    std::uint32_t pointStride = 1;
    HybridTransfer transfer;
    HybridLight light;
    /// In the box: what lies in all of them is drawn. Their normals are of any length.
    std::vector<HalfSpace> clips;

    bool corrected() const { return representation == HybridRepresentation::residual && step->bricks; }
    bool hasPoints() const { return representation == HybridRepresentation::points && step->points; }
    /// How many points are looked at: those that the curve hides are among them.
    std::uint32_t pointCount() const {
        const auto points = static_cast<std::uint32_t>(hasPoints() ? step->points->points.size() : 0);
        return points / pointStride + (points % pointStride != 0 ? 1 : 0);
    }
    /// Which point is the one of number `drawn`: not the same of each run, or lines of points would show.
    std::uint32_t point(std::uint32_t drawn) const {
        const std::uint32_t within = (drawn * 2654435761U >> 16) % pointStride;
        const auto last = static_cast<std::uint32_t>(step->points->points.size() - 1);
        return std::min(drawn * pointStride + within, last);
    }
    /// Edge of a point over that of the cell that it stands for: runs lie on surfaces, mostly. No more than
    /// still looks like what it is; the rest is made up for by optical depth.
    double pointGrowth() const { return std::min(std::sqrt(static_cast<double>(pointStride)), 3.0); }
    double pointStrength() const { return pointStride / (pointGrowth() * pointGrowth()); }
    /// How far it is in layer space from one place in the box to another.
    double layerLength(const glm::dvec3& inBox) const;
};

/// `pointStride`: as HybridPlan's.
HybridPlan planHybrid(const HybridStyle& style, const glm::dmat4& layerToWorld,
                      std::shared_ptr<const HybridStep> step, const Camera& camera,
                      std::uint32_t pointStride);

}  // namespace mote::render
