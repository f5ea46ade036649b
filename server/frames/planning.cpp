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

std::shared_ptr<Planning> Planning::begin(const RenderJob& job, const PictureHistory& history,
                                          std::shared_ptr<storage::BlockBudget> budget, Make make,
                                          render::WorkInTurns::Duration leastTurn) {
    auto held = HeldMemory::whereThereIsRoom(std::move(budget), planningBytes(job.task->view));
    if (!held) return nullptr;
    return std::make_shared<Planning>(historyFor(*job.task, history), *std::move(held), std::move(make),
                                      leastTurn);
}

Planning::Planning(PictureHistory history, HeldMemory held, Make make,
                   render::WorkInTurns::Duration leastTurn)
    : history_(std::move(history)),
      held_(std::move(held)),
      work_([this, make = std::move(make)] { draft_ = make(history_, why_); }, leastTurn) {}

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
