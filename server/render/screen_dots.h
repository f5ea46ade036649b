// SPDX-License-Identifier: GPL-3.0-or-later
//
// The dots of a plan, and the points of its hybrid volumes, as devices take them: their depths told in slabs.
// Pure functions, shared by all devices.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>
#include <vector>

#include "server/render/frame_plan.h"
#include "server/render/hybrid/point_looks.h"

namespace mote::render {

struct ScreenDot {
    float x = 0.0F, y = 0.0F;  ///< pixels
    DotFootprint ink{0.0F,
                     0.0F};  ///< with the dot's opacity in `most`; of another shape, as coverage() takes it
    float place = 0.0F;      ///< slabs from the plan's nearDepth, 0 to the number of slabs
    glm::vec3 color{0.0F};   ///< linear RGB
    PointShape shape = PointShape::disc;
    float peak = 1.0F;  ///< of a gaussian, its coverage in the middle, were it not held to 1

    /// Its opacity in a pixel whose centre lies (dx, dy) from its own; nothing beyond `ink.reach` on an axis.
    float opacity(float dx, float dy) const;
};

/// Front to back; of equal depth in their order.
std::vector<ScreenDot> screenDots(const FramePlan& plan);

/// Adds the points of all hybrid volumes that may be seen, in their order, not sorted by depth. `looks`: of
/// the picture before, one a layer. Works in parallel.
void addScreenSplats(const FramePlan& plan, std::vector<KeptPointLooks>& looks, std::vector<ScreenDot>& dots);

inline float ScreenDot::opacity(float dx, float dy) const {
    if (shape == PointShape::square) {
        const bool met = dx >= -ink.reach && dx < ink.reach && dy >= -ink.reach && dy < ink.reach;
        return met ? ink.most : 0.0F;
    }
    const float square = dx * dx + dy * dy;
    if (shape == PointShape::disc) return ink.coverage(std::sqrt(square));
    // Cut at three standard deviations; where points are close together it is more than opaque in its middle.
    if (square >= ink.reach * ink.reach) return 0.0F;
    return ink.most * std::min(1.0F, peak * std::exp(-4.5F * square / (ink.reach * ink.reach)));
}

}  // namespace mote::render
