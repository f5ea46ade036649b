// SPDX-License-Identifier: GPL-3.0-or-later
//
// These functions map the box of a primitive to pixels and slabs, in double precision. Pure functions of a
// plan, shared by all devices.
#pragma once

#include <glm/mat4x4.hpp>

#include "server/render/plan/frame_plan.h"

namespace mote::render {

/// Box [0, 1]^3 to (px * w, py * w, slab, w): px and py in pixels from the picture's upper left corner; slab
/// in slabs of the first section in which the box lies, from its first on, before slabBends(); w is the depth
/// (perspective) or 1.
glm::dmat4 boxToScreen(const FramePlan& plan, const glm::dmat4& boxToEye);

/// The bends of what lies in a box.
SlabBends slabBends(const FramePlan& plan, const glm::dmat4& boxToEye);

}  // namespace mote::render
