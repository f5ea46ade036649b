// SPDX-License-Identifier: GPL-3.0-or-later
//
// Direction: of a line on the screen, which has no sign. A value.
#pragma once

#include <cmath>
#include <stop_token>
#include <vector>

#include "server/render/ink/raster.h"

namespace mote::render {

/// As a vector of twice its angle; zero where there is none, as a surface faces the eye.
struct Direction {
    float x = 0.0F, y = 0.0F;
};

inline Direction directionOf(float angle) {
    return angle == 0.0F ? Direction{} : Direction{std::cos(2.0F * angle), std::sin(2.0F * angle)};
}

/// Of all pixels; where `stop` is requested meanwhile, not of all.
std::vector<Direction> directionsOf(const Raster<float>& angles, const std::stop_token& stop);

}  // namespace mote::render
