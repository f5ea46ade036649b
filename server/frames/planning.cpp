// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/frames/planning.h"

#include <algorithm>
#include <utility>

namespace mote::server {
namespace {

/// About what planning takes in memory at most, apart from the plan: so much a pixel of each layer.
std::uint64_t planningBytes(const View& view) {
    constexpr std::uint64_t ofInk = 64, ofOthers = 32;
    std::uint64_t bytes = 0;
    for (const Layer& layer : view.layers) {
        if (layer.opacity > 0.0) bytes += layer.ink() != nullptr ? ofInk : ofOthers;
    }
    return bytes * view.width * view.height;
}

/// All but points and volumes, which the device draws.
bool plansLong(const View& view) {
    return std::any_of(view.layers.begin(), view.layers.end(), [](const Layer& layer) {
        const bool particles = layer.particles() != nullptr && !layer.highlight;
        return layer.opacity > 0.0 && !particles && layer.hybrid() == nullptr;
    });
}

/// Without its draft. Of the dots a copy of its own where they may have to be as they were.
PictureHistory historyFor(const ViewTask& task, const PictureHistory& history) {
    return {.quality = history.quality,
            .steps = history.steps,
            .hybrids = history.hybrids,
            .exactPoints = history.exactPoints,
            .dots = task.finalOnly ? copyOf(history.dots) : history.dots};
}

}  // namespace

bool isPlannedInTurns(const RenderJob& job) {
    return job.stage != Stage::quick && job.pause.stop_possible() && plansLong(job.task->view);
}

Planning::Planning(const RenderJob& job, const PictureHistory& history, Make make,
                   render::WorkInTurns::Duration leastTurn)
    : history_(historyFor(*job.task, history)),
      bytes_(planningBytes(job.task->view)),
      work_([this, make = std::move(make)] { draft_ = make(history_, why_); }, leastTurn) {}

bool Planning::hold(const std::shared_ptr<storage::BlockBudget>& budget) {
    // Nobody's blocks go for one that is more than its share.
    const bool fits = budget == nullptr || bytes_ <= budget->limit() / 2;
    if (!held_ && fits) held_ = HeldMemory::whereThereIsRoom(budget, bytes_);
    return held_.has_value();
}

Result<std::unique_ptr<Draft>> Planning::take(PictureHistory& history, Making& why) {
    history.quality = history_.quality;
    history.steps = std::move(history_.steps);
    history.hybrids = std::move(history_.hybrids);
    history.exactPoints = history_.exactPoints;
    history.dots = std::move(history_.dots);
    why = std::move(why_);
    return std::move(draft_);
}

}  // namespace mote::server
