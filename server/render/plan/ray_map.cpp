// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/ray_map.h"

#include <glm/matrix.hpp>

namespace mote::render {

RayMap::RayMap(const FramePlan& plan, const glm::dmat4& boxToEye, double nearDepth, double thickness) {
    const glm::dmat4 eyeToBox = glm::inverse(boxToEye);
    const glm::dvec3 right(eyeToBox[0]), up(eyeToBox[1]), away(-eyeToBox[2]), eye(eyeToBox[3]);
    const bool perspective = plan.camera.perspective();
    const double spread = perspective ? nearDepth : 1.0;
    const double turn = perspective ? thickness : 0.0;
    entry = {eye + nearDepth * away, spread * right, spread * up};
    advance = {thickness * away, turn * right, turn * up};
}

}  // namespace mote::render
