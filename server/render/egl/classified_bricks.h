// SPDX-License-Identifier: GPL-3.0-or-later
//
// ClassifiedBricks: what a transfer function makes of the bricks of a field, as shaders/grid.glsl reads
// it: where something is seen, how far it is to there, how long a segment of a ray may be. A value; made in
// main memory, the upload is the frame's.
#pragma once

#include <cstdint>
#include <vector>

#include "server/render/egl/table_entries.h"
#include "server/render/plan/grid_sights.h"

namespace mote::render {

struct ClassifiedBricks {
    ClassifiedBricks() = default;
    ClassifiedBricks(const CorrectedField& samples, const GridSight& seen);

    /// One word a brick, x fastest, as grid.glsl says.
    std::vector<std::uint32_t> words;
    /// Bricks in which something is seen, x | y << 10 | z << 20.
    std::vector<std::uint32_t> visible;
    std::vector<TableEntry> table;
};

}  // namespace mote::render
