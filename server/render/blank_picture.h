// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is seen where nothing is: background, encoded alike by all devices. Pure functions.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>

#include "server/render/plan/frame_plan.h"
#include "server/render/plan/picture.h"

namespace mote::render {

/// A pixel of linear RGB in a format, in the first bytes; the others are 0.
std::array<std::uint8_t, 8> blankPixel(const glm::dvec3& background, PixelFormat format);

/// A picture of nothing but background.
Picture blankPicture(const FramePlan& plan, PixelFormat format);

}  // namespace mote::render
