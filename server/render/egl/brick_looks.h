// SPDX-License-Identifier: GPL-3.0-or-later
//
// BrickLooks: what a transfer function makes of the bricks of a hybrid volume, as shaders/hybrid.glsl reads
// it: where something is seen, how far it is to there, how long a stretch of a ray may be. A value; made in
// main memory, the upload is the frame's.
#pragma once

#include <cstdint>
#include <vector>

#include "server/render/cpu/composite_frame.h"
#include "server/render/egl/table_entries.h"
#include "server/render/layers/hybrid/hybrid_plan.h"

namespace mote::render {

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
