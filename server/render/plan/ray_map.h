// SPDX-License-Identifier: GPL-3.0-or-later
//
// A RayMap holds the rays of a picture's pixels in a layer's plot box, told by depth in slabs. A value, in
// double precision; a pure function of a plan, shared by all devices.
#pragma once

#include <array>
#include <glm/vec3.hpp>

#include "server/render/plan/frame_plan.h"

namespace mote::render {

/// The ray through (x, y) of the picture's window (camera.h) is, in the box [0, 1]^3, at s in
/// entry + s * advance, both linear in (1, x, y): s counts a thickness from a depth on. Not finite where the
/// layer's transform is degenerate.
struct RayMap {
    std::array<glm::dvec3, 3> entry;
    std::array<glm::dvec3, 3> advance;

    /// s = 0 at `nearDepth`.
    RayMap(const FramePlan& plan, const glm::dmat4& boxToEye, double nearDepth, double thickness);
};

}  // namespace mote::render
