// SPDX-License-Identifier: GPL-3.0-or-later
//
// Modalities: what a drawing is made from beside its lines (the 3D stage of the dissertation's section
// 2.3.2): pictures of one size, of the first surface in each pixel. Values.
//
// Direction: of a line on the screen, which has no sign. A value.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/vec2.hpp>
#include <numbers>
#include <stop_token>
#include <vector>

#include "server/render/ink/raster.h"

namespace mote::render {

/// The angle of a direction on the screen; along its x axis the other way, pi, as 0 stands for none.
/// Directions of strokes have no sign.
inline float angleOf(const glm::dvec2& across) {
    const auto angle = static_cast<float>(std::atan2(across.y, across.x));
    return angle == 0.0F ? std::numbers::pi_v<float> : angle;
}

struct Modalities {
    static constexpr std::uint32_t nothing = UINT32_MAX;

    /// How light a pixel is, linear, 0 to 1; where nothing is seen, as the paper: 1, or 0 under light ink.
    Raster<float> grey;
    /// Along the line of sight, world units; infinity where nothing is seen.
    Raster<float> depth;
    /// Of the surface's normal on the screen, radians from its x axis to its (downward) y axis, in [-pi, pi]
    /// (angleOf); 0 where the normal points at the eye, or nothing is seen.
    Raster<float> angle;
    /// Which part of the scene is seen; `nothing` where none is.
    Raster<std::uint32_t> part;
    /// What the depths of a whole scene differ by, world units, above 0: steps are told by it.
    double extent = 1.0;
    /// How much of the surface's normal lies on the screen: the sine of its angle to the screen's axis, below
    /// 0 if it points away from there. Empty if it is not known.
    Raster<float> across = {};
};

/// As a vector of twice its angle; zero if there is none, as a surface faces the eye.
struct Direction {
    float x = 0.0F, y = 0.0F;
};

inline Direction directionOf(float angle) {
    return angle == 0.0F ? Direction{} : Direction{std::cos(2.0F * angle), std::sin(2.0F * angle)};
}

/// The directions of all pixels; if `stop` is requested meanwhile, not of all.
std::vector<Direction> directionsOf(const Raster<float>& angles, const std::stop_token& stop);

}  // namespace mote::render
