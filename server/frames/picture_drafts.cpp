// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a PictureMaker keeps of pictures that give way to others.
#include <fmt/format.h>

#include <algorithm>
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

/// Takes the memory that a job's picture needs, once; false where it waits for some. Quick ones of a screen
/// are part of what the server has beside: they are drawn one at a time. Errors: resourceExhausted.
Result<bool> PictureMaker::admit(const RenderJob& job, PictureHistory& history, Making& why) {
    if (memory_ == nullptr || why.memory.bytes() > 0) return true;
    constexpr std::uint64_t mib = std::uint64_t{1} << 20, quick = 64 * mib;
    constexpr std::chrono::minutes patience{1};
    const View& view = job.task->view;
    const std::uint64_t bytes = pictureBytes(view, job, steps_);
    if (job.stage == Stage::quick && bytes <= quick) return true;
    if (auto taken = memory_->take(bytes)) {
        why.memory = *std::move(taken);
        history.wait.reset();
        return true;
    }
    if (bytes > memory_->most(bytes) || memory_->taken() == 0) {
        return Error{
            ErrorCode::resourceExhausted, "view",
            fmt::format("a picture of {} x {} pixels with these layers may take {} MiB while it is "
                        "made, and the server has {} MiB for it: fewer pixels or layers take less, "
                        "and --memory of the server gives more",
                        view.width, view.height, bytes / mib,
                        (bytes > memory_->most(bytes) ? memory_->most(bytes) : memory_->room()) / mib)};
    }
    const auto now = Clock::now();
    auto& wait = history.wait;
    if (!wait || wait->task.lock() != job.task || wait->givenBack != memory_->givenBack())
        wait = MemoryWait{job.task, now, memory_->givenBack()};
    if (now - wait->since >= patience) {
        wait.reset();
        return Error{ErrorCode::resourceExhausted, "view",
                     fmt::format("a picture of {} x {} pixels with these layers may take {} MiB while it is "
                                 "made, which others' pictures have and did not give back for a minute: ask "
                                 "again later",
                                 view.width, view.height, bytes / mib)};
    }
    why.waits = true;
    why.until = wait->since + patience;
    return false;
}

}  // namespace mote::server
