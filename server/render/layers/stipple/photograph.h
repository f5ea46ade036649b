// SPDX-License-Identifier: GPL-3.0-or-later
//
// A stippled photograph: dots of a plane hierarchy in the tones of a picture (dissertation 2.2.3.3,
// docs/STIPPLES.md, "Photographs"). Pure; uses all threads of the calling arena and gives the same dots on
// any number of them.
#pragma once

#include <cstdint>
#include <vector>

#include "protocol/scene/stipple_style.h"
#include "server/render/layers/stipple/pixel_map.h"
#include "server/render/layers/stipple/plane_tiles.h"
#include "server/render/plan/dot.h"
#include "server/render/plan/picture.h"

namespace mote::render {

/// How much work goes into it. Each step starts from what the one before it made.
struct PhotographEffort {
    bool weighting = true;  ///< each dot goes to the weighted middle of the four quarters of its surroundings
    /// Steps of weighted Voronoi relaxation, in which points of the hierarchy are drawn or left out until
    /// cells hold about one wanted dot.
    int relaxations = 0;

    bool operator==(const PhotographEffort&) const = default;
};

/// The effort in motion: select and place.
inline constexpr PhotographEffort quickPhotograph{};
/// The effort at rest.
inline constexpr PhotographEffort finePhotograph{true, 4};

/// The dots of the picture, those within it only.
std::vector<TileDot> stipplePhotograph(const PlaneTiles& tiles, const PixelMap& wanted,
                                       const TileFrame& frame, const PhotographEffort& effort);

/// The dots of a stipple layer on the plane, a picture's tones as a view shows them: those in a picture of
/// width x height pixels, behind all that has a depth. The photograph is as large as fits, in the middle.
Dots photographDots(const PlaneTiles& tiles, const PixelMap& luminance, std::uint32_t width,
                    std::uint32_t height, const StippleStyle& style, const PhotographEffort& effort);

/// The linear luminance (ITU-R BT.709) of an srgb8 picture.
PixelMap luminanceOf(const Picture& picture);

}  // namespace mote::render
