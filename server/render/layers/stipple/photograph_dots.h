// SPDX-License-Identifier: GPL-3.0-or-later
//
// The dots of a stipple layer on the plane: a picture's tones as a view shows them. Pure; uses all threads of
// the calling arena.
#pragma once

#include <cstdint>

#include "protocol/scene/stipple_style.h"
#include "server/render/layers/stipple/photograph.h"
#include "server/render/plan/dot.h"
#include "server/render/plan/picture.h"

namespace mote::render {

/// The dots in a picture of width x height pixels, behind all that has a depth. The photograph is as large as
/// fits, in the middle.
Dots photographDots(const PlaneTiles& tiles, const PixelMap& luminance, std::uint32_t width,
                    std::uint32_t height, const StippleStyle& style, const PhotographEffort& effort);

/// The linear luminance (ITU-R BT.709) of an srgb8 picture.
PixelMap luminanceOf(const Picture& picture);

}  // namespace mote::render
