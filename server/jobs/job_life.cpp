// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_life.h"

#include <fmt/format.h>

#include <utility>

namespace mote::server {
namespace {

using Stage = JobLife::Stage;

JobStep ended(JobLife life, Stage stage, std::string error = {}) {
    life.stage = stage;
    return {life, {JobDeed::clear}, std::move(error)};
}

JobStep failedLife(const JobLife& life, std::string error) {
    return ended(life, Stage::failed, std::move(error));
}

JobStep moved(JobLife life, Stage stage, std::vector<JobDeed> deeds = {}) {
    life.stage = stage;
    return {life, std::move(deeds)};
}

/// Of a job whose run has not begun.
JobStep nextOfWaiting(JobLife life, JobEvent event, std::string_view why) {
    const bool starts = life.stage == Stage::starts;
    switch (event) {
        case JobEvent::chosen:
            if (life.stage == Stage::waits) return moved(life, Stage::starts, {JobDeed::start});
            break;
        case JobEvent::rested:
            if (life.stage == Stage::pauses) return moved(life, Stage::waits);
            break;
        case JobEvent::held:
            return moved(life, Stage::waits, {JobDeed::hold});
        case JobEvent::denied:
            return moved(life, Stage::waits, {JobDeed::lookLater});
        case JobEvent::refused:
            ++life.attempts;
            return failedLife(life, std::string(why));
        case JobEvent::begun:
            if (!starts) return moved(life, life.stage, {JobDeed::drop});
            ++life.attempts;
            return moved(life, Stage::runs, {JobDeed::go});
        case JobEvent::cancel:
            life.cancelled = true;
            return ended(life, Stage::cancelled);
        default:
            break;
    }
    return {life};
}

/// Of a job that runs, or may.
JobStep nextOfRunning(JobLife life, JobEvent event) {
    const bool runs = life.stage == Stage::runs;
    switch (event) {
        case JobEvent::cancel: {
            const bool first = !std::exchange(life.cancelled, true);
            return moved(life, life.stage,
                         runs && first ? std::vector{JobDeed::stop} : std::vector<JobDeed>());
        }
        case JobEvent::found:
            if (runs) break;
            return moved(
                life, Stage::runs,
                life.cancelled ? std::vector{JobDeed::watch, JobDeed::stop} : std::vector{JobDeed::watch});
        case JobEvent::hidden:
            if (!runs) return moved(life, Stage::unsure, {JobDeed::lookLater});
            break;
        case JobEvent::gone:
            return moved(life, Stage::over, {JobDeed::look});
        case JobEvent::begun:
            return moved(life, life.stage, {JobDeed::drop});
        default:
            break;
    }
    return {life};
}

/// Others ended it, the machine or someone's kill, and it is no fault of its own. Again, but not for ever.
JobStep nextOfTaken(JobLife life, std::string_view why) {
    if (life.attempts >= life.mostAttempts) {
        const auto often = life.attempts == 2 ? "twice" : fmt::format("{} times", life.attempts);
        return failedLife(life, fmt::format("was interrupted {} ({}): submit it again", often, why));
    }
    ++life.interrupted;
    return moved(life, Stage::waits);
}

/// No attempt of its own has failed. Not for ever either: it may be this job that needs more than there will
/// be.
JobStep nextOfRoomless(JobLife life, std::string_view why) {
    if (++life.roomless >= mostRoomless)
        return failedLife(life, fmt::format("{} (tried {} times)", why, mostRoomless));
    --life.attempts;
    return moved(life, Stage::pauses, {JobDeed::rest});
}

JobStep nextOfOver(JobLife life, JobEvent event, std::string_view why) {
    switch (event) {
        case JobEvent::cancel:
            life.cancelled = true;
            return {life};
        case JobEvent::hidden:
            return moved(life, Stage::over, {JobDeed::lookLater});
        case JobEvent::begun:
            return moved(life, life.stage, {JobDeed::drop});
        case JobEvent::made:
            // A dataset is published, whoever asked for its end meanwhile.
            return ended(life, life.cancelled && life.keepsFiles ? Stage::cancelled : Stage::succeeded);
        case JobEvent::broken:
        case JobEvent::taken:
        case JobEvent::roomless:
            if (life.cancelled) return ended(life, Stage::cancelled);
            if (event == JobEvent::broken) return failedLife(life, std::string(why));
            return event == JobEvent::taken ? nextOfTaken(life, why) : nextOfRoomless(life, why);
        default:
            return {life};
    }
}

}  // namespace

JobStep next(const JobLife& life, JobEvent event, std::string_view why) {
    switch (life.stage) {
        case Stage::waits:
        case Stage::pauses:
        case Stage::starts:
            return nextOfWaiting(life, event, why);
        case Stage::runs:
        case Stage::unsure:
            return nextOfRunning(life, event);
        case Stage::over:
            return nextOfOver(life, event, why);
        case Stage::succeeded:
            // What it has made goes; that it was made stays true.
            if (event == JobEvent::cancel && life.keepsFiles && !life.cancelled) {
                auto gone = ended(life, Stage::succeeded);
                gone.life.cancelled = true;
                return gone;
            }
            break;
        default:
            break;
    }
    return event == JobEvent::begun ? JobStep{life, {JobDeed::drop}} : JobStep{life};
}

bool isLive(JobLife::Stage stage) {
    return stage < Stage::succeeded;
}

bool takesPlace(JobLife::Stage stage) {
    return stage == Stage::starts || stage == Stage::runs || stage == Stage::unsure;
}

}  // namespace mote::server
