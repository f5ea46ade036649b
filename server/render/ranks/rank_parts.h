// SPDX-License-Identifier: GPL-3.0-or-later
//
// RankParts: what a rank keeps of the steps that it draws, from picture to picture: the parts of the cpu
// device. Owned by the rank's device or worker; one thread, which uses all threads of the arena.
#pragma once

#include <oneapi/tbb/task_arena.h>

#include <string>

#include "server/render/cpu/composite.h"
#include "server/render/cpu/flat_points.h"
#include "server/render/cpu/frame_dots.h"
#include "server/render/cpu/frame_points.h"
#include "server/render/cpu/leaf_cells.h"
#include "server/render/cpu/resident_hybrids.h"
#include "server/render/cpu/resident_volumes.h"

namespace mote::render {

struct RankParts {
    /// `threads`: 0: as many as the process may use.
    explicit RankParts(unsigned threads)
        : arena(threads == 0 ? oneapi::tbb::task_arena::automatic : static_cast<int>(threads)) {}

    oneapi::tbb::task_arena arena;
    ResidentVolumes volumes;
    ResidentHybrids hybrids;
    ResidentLeaves leaves;
    FramePoints points;
    FrameDots dots;
    FlatPoints flat;

    /// What of each layer's volume can be seen. Throws storage::StorageError.
    std::vector<VisibleVolume> visible(const FramePlan& plan) {
        std::vector<VisibleVolume> result;
        for (const auto& layer : plan.layers) result.push_back(volumes.of(layer.step, layer.style));
        return result;
    }
    std::vector<VisibleHybrid> visibleHybrids(const FramePlan& plan) {
        std::vector<VisibleHybrid> result;
        for (const auto& hybrid : plan.hybrids) result.push_back(hybrids.of(hybrid));
        return result;
    }
    void dropExpired() {
        volumes.dropExpired();
        hybrids.dropExpired();
        leaves.dropExpired();
    }
};

}  // namespace mote::render
