// SPDX-License-Identifier: GPL-3.0-or-later
//
// SurfaceView: how the surface of a stipple layer is looked at: from layer space to eye space and pixels. A
// value in double precision, made once a picture.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "protocol/scene/view.h"

namespace mote::render {

struct SurfaceView {
    glm::dmat4 layerToEye;
    glm::dmat3 areaToEye;  ///< takes area vectors (normal times area) from layer to eye space
    glm::dmat3 turnToEye;  ///< directions, world to eye
    glm::dvec2 size;       ///< of the picture, pixels
    double pixels;         ///< a unit at depth 1 (perspective) or anywhere (orthographic)
    bool perspective;
    double nearest;  ///< depth; nothing nearer is seen

    SurfaceView(const View& view, const glm::dmat4& transform);

    glm::dvec3 toEye(const glm::dvec3& inLayer) const {
        return glm::dvec3(layerToEye * glm::dvec4(inLayer, 1.0));
    }
    /// Unit, from a place in eye space.
    glm::dvec3 towardsEye(const glm::dvec3& inEye) const;
    /// Pixels from the upper left corner; the place must have a depth that is seen.
    glm::dvec2 onScreen(const glm::dvec3& inEye) const;
    bool inFront(const glm::dvec3& inEye) const { return -inEye.z > nearest; }
    /// Square pixels that a small area shows at a place, both in eye space; 0 where it is seen edge-on.
    double pixelArea(const glm::dvec3& inEye, const glm::dvec3& area) const;
};

}  // namespace mote::render
