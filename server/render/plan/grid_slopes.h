// SPDX-License-Identifier: GPL-3.0-or-later
//
// How steeply a grid field changes at its samples: what the opacity of gradients goes by (docs/PICTURE.md,
// "Hybrid volumes"). Values; a pure function, which works in parallel.
#pragma once

#include <cstdint>
#include <vector>

#include "server/render/plan/grid_field.h"

namespace mote::render {

/// In 255ths, in the order of the samples; four more than these can be read.
struct GridSlopes {
    std::vector<std::uint8_t> coarse, bricks;
};

/// `corrected`: whether the bricks are drawn, where there are some.
GridSlopes gridSlopes(const GridField& field, bool corrected);

}  // namespace mote::render
