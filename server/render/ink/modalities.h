// SPDX-License-Identifier: GPL-3.0-or-later
//
// Modalities: what a drawing is made from beside its lines (the 3D stage of the dissertation's section
// 2.3.2): pictures of one size, of the first surface in each pixel. Values.
#pragma once

#include <cstdint>
#include <limits>

#include "server/render/ink/raster.h"

namespace mote::render {

struct Modalities {
    static constexpr std::uint32_t nothing = UINT32_MAX;

    /// How light a pixel is, linear, 0 to 1; where nothing is seen, as the paper: 1.
    Raster<float> grey;
    /// Along the line of sight, world units; infinity where nothing is seen.
    Raster<float> depth;
    /// Of the surface's normal on the screen, radians from its x axis to its (downward) y axis, in [-pi, pi);
    /// 0 where the normal points at the eye, or nothing is seen.
    Raster<float> angle;
    /// Which part of the scene is seen; `nothing` where none is.
    Raster<std::uint32_t> part;
    /// What the depths of a whole scene differ by, world units, above 0: steps are told by it.
    double extent = 1.0;
};

}  // namespace mote::render
