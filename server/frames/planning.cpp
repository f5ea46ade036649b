// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/frames/planning.h"

#include <algorithm>
#include <utility>

namespace mote::server {
namespace {

/// All but points, volumes and surfaces, which are made as they are drawn.
bool plansLong(const View& view) {
    return std::any_of(view.layers.begin(), view.layers.end(), [](const Layer& layer) {
        const bool particles = layer.particles() != nullptr && !layer.highlight;
        return layer.opacity > 0.0 && !particles && layer.hybrid() == nullptr && layer.mesh() == nullptr;
    });
}

/// Without its draft. Of the dots a copy of its own where they may have to be as they were.
PictureHistory historyFor(const ViewTask& task, const PictureHistory& history) {
    return {.quality = history.quality,
            .steps = history.steps,
            .hybrids = history.hybrids,
            .exactPoints = history.exactPoints,
            .dots = task.finalOnly ? copyOf(history.dots) : history.dots,
            .boxes = history.boxes,
            .wait = history.wait};
}

}  // namespace

bool isPlannedInTurns(const RenderJob& job) {
    return job.stage != Stage::quick && job.pause.stop_possible() && plansLong(job.task->view);
}

Planning::Planning(const RenderJob& job, const PictureHistory& history, Make make,
                   render::WorkInTurns::Duration leastTurn)
    : history_(historyFor(*job.task, history)),
      work_([this, make = std::move(make)] { draft_ = make(history_, why_); }, leastTurn) {}

Result<std::unique_ptr<Draft>> Planning::take(PictureHistory& history, Making& why) {
    history.quality = history_.quality;
    history.steps = std::move(history_.steps);
    history.hybrids = std::move(history_.hybrids);
    history.exactPoints = history_.exactPoints;
    history.dots = std::move(history_.dots);
    history.boxes = std::move(history_.boxes);
    history.wait = std::move(history_.wait);
    why = std::move(why_);
    return std::move(draft_);
}

}  // namespace mote::server
