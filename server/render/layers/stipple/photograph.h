// SPDX-License-Identifier: GPL-3.0-or-later
//
// A stippled photograph: dots of a plane hierarchy in the tones of a picture (dissertation 2.2.3.3,
// docs/STIPPLES.md, "Photographs"). Pure; uses all threads of the calling arena and gives the same dots on
// any number of them.
#pragma once

#include <vector>

#include "server/render/layers/stipple/pixel_map.h"
#include "server/render/layers/stipple/plane_tiles.h"

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

}  // namespace mote::render
