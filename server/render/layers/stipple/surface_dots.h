// SPDX-License-Identifier: GPL-3.0-or-later
//
// The dots of a stippled surface: chosen, placed, hidden, jittered and brought to the screen
// (docs/STIPPLES.md, "Surfaces on the screen"). Pure functions that use all threads of the calling arena and
// give the same result on any number of them.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "protocol/scene/view.h"
#include "server/render/layers/stipple/stipple_surface.h"
#include "server/render/layers/stipple/wanted_density.h"
#include "server/render/plan/dot.h"

namespace mote::render {

/// A point of the hierarchy that is seen.
struct ShownPoint {
    std::uint32_t point = 0;  ///< index in the hierarchy: the same dot from picture to picture
    glm::vec3 position{0};    ///< layer space, on the surface
    float presence = 1.0F;    ///< 0 to 1: below 1 while it fades
};

/// One layer in one view: what its functions have in common. Refers to the surface.
class SurfaceDots {
  public:
    /// `clips`: what of the surface they cut away is not there.
    SurfaceDots(const StippleSurface& surface, const StippleStyle& style, const View& view,
                const glm::dmat4& transform, HalfSpaces clips = {});

    SurfaceDots(const SurfaceDots&) = delete;
    SurfaceDots& operator=(const SurfaceDots&) = delete;

    /// The points that are drawn, those that are hidden among them, in the hierarchy's order.
    std::vector<PlacedPoint> chosen() const;
    /// Whether a place on the surface is seen: in the picture, not cut away, and not hidden by the surface,
    /// unless the style sees through it.
    bool visible(std::size_t point, const glm::vec3& position) const;
    /// Those of `points` that are visible.
    std::vector<ShownPoint> seen(const std::vector<PlacedPoint>& points) const;
    /// The dots, in the order of `points`.
    Dots onScreen(const std::vector<ShownPoint>& points) const;

  private:
    enum class Value { none, tone, depth, x, y, z };

    glm::dvec3 jittered(const ShownPoint& shown, const glm::dvec3& inEye, float share) const;
    float valueOf(const ShownPoint& shown, double depth, float tone) const;
    Dot dotOf(const ShownPoint& shown) const;

    const StippleSurface& surface_;
    const StippleStyle& style_;
    HalfSpaces clips_;
    double size_, leastSize_;  // of dots, pixels
    glm::vec3 color_;          // linear RGB
    std::optional<ColorMap> colorMap_;
    Value value_;  // what drives size and colour, from 0 to 1
    SurfaceView view_;
    WantedDensity wanted_;
    glm::dvec3 eyeInLayer_;                // perspective: the eye; orthographic: the direction towards it
    double nearestDepth_, farthestDepth_;  // of the surface's bounds
    double border_;                        // pixels around the picture in which a dot reaches into it
};

}  // namespace mote::render
