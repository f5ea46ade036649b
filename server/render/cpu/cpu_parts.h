// SPDX-License-Identifier: GPL-3.0-or-later
//
// CpuParts: what the cpu device, or a rank of several, keeps of the steps that it draws, from picture to
// picture. Owned by the device or the rank's worker; one thread, which uses all threads of the arena.
#pragma once

#include <oneapi/tbb/task_arena.h>

#include "server/render/cpu/composite/composite.h"
#include "server/render/cpu/flat_points.h"
#include "server/render/cpu/frame_dots.h"
#include "server/render/cpu/leaf_cells.h"
#include "server/render/cpu/point_groups.h"
#include "server/render/cpu/resident_fields.h"
#include "server/render/cpu/tile_points.h"

namespace mote::render {

struct CpuParts {
    /// `threads`: 0: as many as the process may use.
    explicit CpuParts(unsigned threads)
        : arena(threads == 0 ? oneapi::tbb::task_arena::automatic : static_cast<int>(threads)) {}

    oneapi::tbb::task_arena arena;
    ResidentFields fields;
    ResidentLeaves leaves;
    ResidentGroups groups;
    FramePoints points;
    FrameDots dots;
    FlatPoints flat;

    void dropExpired() {
        fields.dropExpired();
        leaves.dropExpired();
        groups.dropExpired();
    }
};

}  // namespace mote::render
