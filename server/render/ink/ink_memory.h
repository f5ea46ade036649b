// SPDX-License-Identifier: GPL-3.0-or-later
//
// InkMemory: what is remembered of one drawing, so that the next one is like it where it shows the same
// (docs/INK.md, "Films"). A value.
#pragma once

#include <cstdint>
#include <vector>

#include "protocol/scene/ink_style.h"
#include "server/render/ink/hatch.h"
#include "server/render/ink/ink_camera.h"
#include "server/render/ink/ink_line.h"
#include "server/render/ink/raster.h"
#include "server/render/ink/segments.h"

namespace mote::render {

struct InkMemory {
    InkStyle style;  ///< a drawing in another style begins anew
    InkCamera camera;
    double extent = 1.0;               ///< Modalities::extent
    Raster<float> depth;               ///< Modalities::depth
    std::vector<InkLine> drawn, left;  ///< lines that were drawn, and that were not
    Segments regions;
    std::vector<HatchAxes> axes;  ///< of the regions
    Raster<float> density;        ///< that was hatched
};

}  // namespace mote::render
