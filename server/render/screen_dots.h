// SPDX-License-Identifier: GPL-3.0-or-later
//
// The dots of a plan as devices take them: front to back, their depths told in slabs. Pure functions, shared
// by all devices.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "server/render/frame_plan.h"

namespace mote::render {

struct ScreenDot {
    float x, y;        ///< pixels
    DotFootprint ink;  ///< with the dot's opacity in `most`
    float place;       ///< slabs from the plan's nearDepth, 0 to the number of slabs
    glm::vec3 color;   ///< linear RGB
};

/// Front to back; of equal depth in their order.
std::vector<ScreenDot> screenDots(const FramePlan& plan);

}  // namespace mote::render
