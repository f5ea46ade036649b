// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a PictureMaker keeps of pictures that give way to others.
#include <utility>

#include "server/frames/mean_picture.h"
#include "server/frames/picture_maker.h"
#include "server/frames/planning.h"

namespace mote::server {

void PictureMaker::drop(std::unique_ptr<Draft>& draft) const {
    const bool ours = draft && device_ && draft->device.lock() == device_;
    if (ours && draft->picture) draft->picture->giveUp();
    if (ours && draft->sight) draft->sight->giveUp();
    draft.reset();
}

void PictureMaker::giveUpDrafts(MeanPicture* mean) const {
    if (mean == nullptr) return;
    for (auto& its : mean->histories()) drop(its.draft);
}

/// The draft of the same job, which planningOf() has left; null: there is none.
std::unique_ptr<Draft> PictureMaker::draftOf(PictureHistory& history) {
    auto draft = std::move(history.draft);
    if (draft && draft->after) history.dots = *std::exchange(draft->after, std::nullopt);
    return draft;
}

/// A draft that is being planned in turns, of the same job or a new one; null where it is planned already or
/// is planned at once. What the history keeps of another job, or of a device that is gone, goes.
std::unique_ptr<Draft> PictureMaker::planningOf(const RenderJob& job, PictureHistory& history) {
    auto& latest = history.draft;
    if (latest && latest->device.lock() == device_ && latest->task == job.task && latest->stage == job.stage)
        return latest->planning ? std::move(latest) : nullptr;
    drop(latest);
    if (!isPlannedInTurns(job)) return nullptr;
    return std::make_unique<Draft>(
        Draft{.task = job.task,
              .stage = job.stage,
              .device = device_,
              .planning = std::make_shared<Planning>(
                  job, history,
                  [this, own = RenderJob{job.session, job.task, job.stage, {}, {}, job.part}](
                      PictureHistory& its, Making& why) { return newDraft(own, its, why); },
                  leastTurn_)});
}

void PictureMaker::keep(std::unique_ptr<Draft> draft, PictureHistory& history) {
    std::uint64_t bytes = draft->picture ? draft->picture->bytes() : draft->sight->bytes();
    for (const auto& fragments : draft->plan.fragments)
        bytes += fragments->capacity() * sizeof(render::Fragment);
    draft->held = {};  // of what it kept before
    auto held = HeldMemory::whereThereIsRoom(steps_.budget(), bytes);
    if (!held) {
        if (draft->picture) draft->picture->giveUp();
        if (draft->sight) draft->sight->giveUp();
        history.lost = draft->task;
        return;
    }
    draft->held = *std::move(held);
    history.draft = std::move(draft);
}

}  // namespace mote::server
