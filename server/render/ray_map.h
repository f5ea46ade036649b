// SPDX-License-Identifier: GPL-3.0-or-later
//
// RayMap: the rays of a picture's pixels in a layer's plot box, told by depth in slabs. A value, in double
// precision; a pure function of a plan, shared by all devices.
#pragma once

#include <array>
#include <glm/vec3.hpp>

#include "server/render/frame_plan.h"

namespace mote::render {

/// The ray through (x, y) of the picture's window (camera.h) is, in the box [0, 1]^3, at slab s in
/// entry + s * advance, both linear in (1, x, y). Not finite where the layer's transform is degenerate.
struct RayMap {
    std::array<glm::dvec3, 3> entry;
    std::array<glm::dvec3, 3> advance;

    RayMap(const FramePlan& plan, const LayerPlan& layer);
    RayMap(const FramePlan& plan, const glm::dmat4& boxToEye);
};

}  // namespace mote::render
