// SPDX-License-Identifier: GPL-3.0-or-later
//
// InkMemory: what is remembered of one drawing, so that the next one is like it where it shows the same
// (docs/INK.md, "Films"). A value.
#pragma once

#include <cstdint>
#include <vector>

#include "server/render/ink/hatch.h"
#include "server/render/ink/ink_camera.h"
#include "server/render/ink/raster.h"
#include "server/render/ink/segments.h"

namespace mote::render {

/// The line that passes a pixel: of several the nearest, one that was drawn before one that was left out.
struct LineMark {
    float depth = 0.0F;                ///< along the line of sight, world units
    float cosine = 0.0F, sine = 0.0F;  ///< of twice its direction on the screen
    enum : std::uint8_t { none, left, drawn } state = none;
};

struct InkMemory {
    InkCamera camera;
    double extent = 1.0;  ///< Modalities::extent
    Raster<float> depth;  ///< Modalities::depth
    Raster<LineMark> lines;
    Segments regions;
    std::vector<HatchFrame> frames;  ///< of the regions
    Raster<float> density;           ///< that was hatched
};

}  // namespace mote::render
