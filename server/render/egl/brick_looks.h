// SPDX-License-Identifier: GPL-3.0-or-later
//
// BrickLooks: what a transfer function makes of the bricks of a hybrid volume, as shaders/hybrid.glsl reads
// it: where something is seen, how far it is to there, how long a stretch of a ray may be. A value; made in
// main memory, the upload is the frame's.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "server/render/cpu/composite_frame.h"
#include "server/render/hybrid/hybrid_plan.h"

namespace mote::render {

/// The integral of extinction and its slope, as the bits of floats; colour; how many entries it is to one
/// with extinction, as the bits of a float.
using TableEntry = std::array<std::uint32_t, 4>;

struct BrickLooks {
    BrickLooks() = default;
    BrickLooks(const HybridPlan& plan, const VisibleHybrid& seen);

    /// Of each brick, x fastest, as hybrid.glsl says.
    std::vector<std::uint32_t> words;
    /// Bricks in which something is seen, x | y << 10 | z << 20.
    std::vector<std::uint32_t> visible;
    std::vector<TableEntry> table;
};

}  // namespace mote::render
