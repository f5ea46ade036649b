// SPDX-License-Identifier: GPL-3.0-or-later
//
// ScreenDots are the dots of a plan as devices take them, and what they take as dots, which is all that
// stands at a depth of its own: their depths told in slabs. Pure functions, shared by all devices.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "server/render/plan/frame_plan.h"

namespace mote::render {

struct ScreenDot {
    float x = 0.0F, y = 0.0F;  ///< pixels
    DotFootprint ink{0.0F};    ///< with the dot's opacity in `most`
    float place = 0.0F;        ///< slabs from the plan's nearDepth, 0 to the number of slabs
    glm::vec3 color{0.0F};     ///< linear RGB
};

/// The plan's dots, fragments and strokes front to back; those of equal depth in this order, and in their
/// own. Uses all threads of the calling arena. Throws std::bad_alloc.
std::vector<ScreenDot> screenDots(const FramePlan& plan);

}  // namespace mote::render
