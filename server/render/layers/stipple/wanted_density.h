// SPDX-License-Identifier: GPL-3.0-or-later
//
// WantedDensity: how dense the dots of a surface are to be around each point of its hierarchy, so that they
// are even on the screen where the tone is: from light, scale and viewing angle (section 2.2.3 of the
// dissertation). Refers to a surface; made once a picture, used by any number of threads.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <cstddef>
#include <vector>

#include "protocol/scene/stipple_style.h"
#include "protocol/scene/view.h"
#include "server/render/layers/stipple/stipple_surface.h"

namespace mote::render {

/// How the surface of a stipple layer is looked at: from layer space to eye space and pixels. Made once a
/// picture.
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
    /// Square pixels that a small area shows at a place, both in eye space; 0 if it is seen edge-on.
    double pixelArea(const glm::dvec3& inEye, const glm::dvec3& area) const;
};

class WantedDensity {
  public:
    /// What it is given must outlive it.
    WantedDensity(const StippleSurface& surface, const StippleStyle& style, const SurfaceView& view);

    struct Wanted {
        float tone = 0.0F;   ///< share of the full density on the screen, 0 to 1
        float share = 0.0F;  ///< of the hierarchy's density; above 1 if it has too few points; 0 out of view
    };
    /// What is wanted around a point's first position.
    Wanted at(std::size_t point) const;
    /// The shares of all points. Uses all threads of the calling arena.
    std::vector<float> shares() const;

  private:
    double tone(double brightness) const;
    double brightness(const glm::dvec3& normal, const glm::dvec3& towardsEye, bool lit) const;

    const StippleSurface& surface_;
    Light parts_;  // its direction apart
    double gamma_;
    bool denseDark_, byTone_;  // what dots look like follows from the tone
    const SurfaceView& view_;
    glm::dvec3 light_;        // towards it, eye space
    glm::vec3 lightInLayer_;  // unit
    double fullDensity_;      // dots a square pixel at full tone
    double margin_;           // pixels around the picture in which dots hold their neighbours in place
};

}  // namespace mote::render
