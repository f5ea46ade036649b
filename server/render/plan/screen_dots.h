// SPDX-License-Identifier: GPL-3.0-or-later
//
// ScreenDots are the dots of a plan as devices take them, and what they take as dots, which is all that
// stands at a depth of its own: their depths told in slabs. Pure functions, shared by all devices.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
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

/// The plan's dots and fragments, in this order, in place of what `placed` has. In turns (in_turns.h), on all
/// threads of the calling arena. Throws std::bad_alloc.
void placeDots(const FramePlan& plan, PlacedDots& placed);

/// The plan's surfaces and strokes, which lie behind those of their depth, in this order. In turns, on all
/// threads of the calling arena. Throws std::bad_alloc.
std::vector<std::shared_ptr<const FragmentMaker>> makersOf(const FramePlan& plan);

/// Appends what they make of some pixels. Any thread. Throws std::bad_alloc.
void placeMade(const std::vector<std::shared_ptr<const FragmentMaker>>& makers, const PixelRect& pixels,
               std::span<const DepthSection> sections, PlacedDots& placed);

/// All that a maker makes, on all threads of the calling arena. Throws std::bad_alloc, also if it is more
/// than fits.
Fragments allOf(const FragmentMaker& maker, std::uint32_t width, std::uint32_t height);

/// The places of dots, front to back. Uses all threads of the calling arena.
std::vector<std::uint32_t> frontToBack(const PlacedDots& placed);

}  // namespace mote::render
