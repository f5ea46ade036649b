// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/screen_map.h"

#include <glm/matrix.hpp>

namespace mote::render {
namespace {

/// Eye space to (px * w, py * w, slab, w), in slabs of a section.
glm::dmat4 eyeToScreen(const FramePlan& plan, const DepthSection& section) {
    const double half = plan.camera.halfHeight();
    const double pixels = plan.height / (2.0 * half);  // a unit at depth 1 (perspective) or anywhere
    const double thickness = section.thickness();
    const glm::dvec4 w =
        plan.camera.perspective() ? glm::dvec4(0.0, 0.0, -1.0, 0.0) : glm::dvec4(0.0, 0.0, 0.0, 1.0);
    const glm::dvec4 x = glm::dvec4(pixels, 0.0, 0.0, 0.0) + 0.5 * plan.width * w;
    const glm::dvec4 y = glm::dvec4(0.0, -pixels, 0.0, 0.0) + 0.5 * plan.height * w;
    const glm::dvec4 slab(0.0, 0.0, -1.0 / thickness, -section.nearDepth / thickness);
    return glm::transpose(glm::dmat4(x, y, slab, w));  // glm takes columns
}

}  // namespace

glm::dmat4 boxToScreen(const FramePlan& plan, const glm::dmat4& boxToEye) {
    return eyeToScreen(plan, slabBends(plan, boxToEye).first) * boxToEye;
}

SlabBends slabBends(const FramePlan& plan, const glm::dmat4& boxToEye) {
    const Bounds inEye = Bounds{glm::dvec3(0.0), glm::dvec3(1.0)}.transformed(boxToEye);
    return slabBends(plan.sections, -inEye.max.z, -inEye.min.z);
}

}  // namespace mote::render
