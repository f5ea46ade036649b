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

/// In any order: one hides others that are deeper, or as deep and listed after it.
struct PlacedDots {
    std::vector<ScreenDot> dots;
    std::vector<double> depths;  ///< of each, as the plan's

    bool before(std::size_t a, std::size_t b) const {
        return depths[a] < depths[b] || (depths[a] == depths[b] && a < b);
    }
};

/// The plan's dots, fragments and strokes, in this order, in place of what `placed` has. In turns
/// (in_turns.h), on all threads of the calling arena. Throws std::bad_alloc.
void placeDots(const FramePlan& plan, PlacedDots& placed);

/// The same front to back. Uses all threads of the calling arena. Throws std::bad_alloc.
std::vector<ScreenDot> screenDots(const FramePlan& plan);

}  // namespace mote::render
