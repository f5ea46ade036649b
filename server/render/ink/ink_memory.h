// SPDX-License-Identifier: GPL-3.0-or-later
//
// InkMemory: what is remembered of one drawing, so that the next one is like it where it shows the same
// (docs/INK.md, "Films"). A value.
//
// InkCamera: where places of a layer are in a picture, and the reverse. A value; pure.
#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "protocol/scene/ink_style.h"
#include "server/render/ink/hatch.h"
#include "server/render/ink/ink_line.h"
#include "server/render/ink/raster.h"

namespace mote::render {

/// A place in a picture.
struct PicturePlace {
    glm::dvec2 at{0.0};  ///< pixels from the upper left corner
    double depth = 0.0;  ///< along the line of sight, world units
};

struct InkCamera {
    glm::dmat4 toEye{1.0};  ///< layer to eye space
    bool perspective = false;
    double pixels = 1.0;  ///< a unit of the plane at depth 1 (perspective), or of any
    glm::dvec2 size{1.0};

    /// Where a place in layer space is that is in front of the eye.
    PicturePlace onPicture(const glm::dvec3& inLayer) const {
        const glm::dvec3 eye(toEye * glm::dvec4(inLayer, 1.0));
        const double scale = pixels / (perspective ? -eye.z : 1.0);
        return {0.5 * size + scale * glm::dvec2(eye.x, -eye.y), -eye.z};
    }
    /// The way back, if toEye is not singular: from pictures to eye space.
    glm::dvec3 inEye(const PicturePlace& place) const {
        const double scale = (perspective ? place.depth : 1.0) / pixels;
        const glm::dvec2 off = scale * (place.at - 0.5 * size);
        return {off.x, -off.y, -place.depth};
    }
};

/// From where a place is in one picture to where it is in another of the same layer.
class PictureMotion {
  public:
    PictureMotion(const InkCamera& from, const InkCamera& to)
        : from_(from),
          to_{.toEye = to.toEye * glm::inverse(from.toEye),
              .perspective = to.perspective,
              .pixels = to.pixels,
              .size = to.size} {}

    PicturePlace operator()(const PicturePlace& place) const { return to_.onPicture(from_.inEye(place)); }

  private:
    InkCamera from_, to_;  // the second from the first's eye space
};

struct InkMemory {
    std::optional<InkStyle> style;  ///< a drawing in another one begins anew
    InkCamera camera;
    double extent = 1.0;               ///< Modalities::extent
    Raster<float> depth;               ///< Modalities::depth
    std::vector<InkLine> drawn, left;  ///< lines that were drawn, and that were not
    std::vector<HatchStroke> hatches;
    Raster<float> density;  ///< that was hatched
};

}  // namespace mote::render
