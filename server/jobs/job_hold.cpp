// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the place is to blame for, and no job: a full disk, no descriptors, a root that is not mounted. Jobs
// wait then, and nothing begins until it may go well again.
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <asio/post.hpp>
#include <cerrno>
#include <chrono>
#include <vector>

#include "protocol/scene/job_request.h"
#include "protocol/scene/system_error.h"
#include "protocol/scene/utf8.h"
#include "server/jobs/job_queue.h"
#include "server/log.h"

namespace mote::server {
namespace {

using State = proto::JobStatus;

constexpr std::chrono::milliseconds kShortHold(500), kLongHold(30000);
constexpr std::chrono::milliseconds kLongestPause(300'000);
constexpr int kMostTries = 12;  // a quarter of an hour, for a disk that someone must clear

}  // namespace

void JobQueue::rememberRoots() {
    for (const auto& entry : roots_.entries()) {
        struct stat status {};
        if (::stat(entry.folder.c_str(), &status) == 0)
            rootPlaces_.push_back({entry.name, entry.folder, status.st_dev});
    }
}

/// The folder alone may still be there, empty, when what was mounted on it is gone.
void JobQueue::lookForRoots() {
    const auto before = std::exchange(away_, {});
    for (const auto& root : rootPlaces_) {
        struct stat status {};
        if (::stat(root.folder.c_str(), &status) != 0) {
            away_.emplace(root.name, systemError(errno, root.folder.string(), "a folder of data is away"));
        } else if (status.st_dev != root.device) {
            away_.emplace(root.name, Error{ErrorCode::notFound, root.folder.string(),
                                           "another file system lies there than when the server began"});
        }
    }
    for (const auto& [name, error] : away_) {
        if (!before.contains(name)) log::warn("jobs of root \"{}\" wait: {}", name, error.toString());
    }
}

/// Of those that the job names; null: they are there. What a film shows, the server finds for it.
const Error* JobQueue::missingRoot(const JobRecord& record) const {
    if (away_.empty()) return nullptr;
    auto names = jobInputs(record.status.request());
    names.push_back({"output", record.status.request().output()});
    for (const auto& [field, name] : names) {
        const auto root = away_.find(name.substr(0, name.find('/')));
        if (root != away_.end()) return &root->second;
    }
    return nullptr;
}

void JobQueue::hold(const Error& why) {
    if (std::exchange(held_, true)) return;
    if (holdFor_.count() == 0) log::warn("no job begins for now: {}", toLogText(why.toString()));
    lookAgainLater();
}

/// Each time for longer.
void JobQueue::lookAgainLater() {
    if (std::exchange(waiting_, true)) return;
    holdFor_ = std::clamp(2 * holdFor_, kShortHold, kLongHold);
    holdTimer_.expires_after(holdFor_);
    holdTimer_.async_wait(whileAlive([this](const std::error_code& code) {
        if (!code) goOnAfterHold();
    }));
}

void JobQueue::goOnAfterHold() {
    held_ = false;
    waiting_ = false;
    if (!table_) return;
    lookAtUnsure();
    const std::vector<std::int64_t> unsaved(table_->unsaved().begin(), table_->unsaved().end());
    for (const auto number : unsaved) {
        const auto* record = table_->find(number);
        if (!record || !changed(*record).ok()) continue;
        if (!isLive(*record)) clearAway(*record);
    }
    scheduleSoon();
}

/// It keeps its place in the queue.
void JobQueue::waitForPlace(JobRecord& record, const Error& why) {
    tellWhyItWaits(record, why);
    hold(why);
}

/// Others go before it meanwhile.
void JobQueue::waitAlone(JobRecord& record, const Error& why) {
    tellWhyItWaits(record, why);
    lookAgainLater();
}

/// No attempt of its own has failed. Each time after a longer pause, but not for ever: it may be this job
/// that needs more than there will be.
void JobQueue::tryLater(JobRecord& record, JobFiles& files, const std::string& why) {
    auto& again = again_.try_emplace(record.number, Again{0, asio::steady_timer(context_)}).first->second;
    if (++again.tries == kMostTries)
        return finish(record, State::FAILED, fmt::format("{} (tried {} times)", why, kMostTries));
    const auto pause = std::min(settings_.placePause * (1 << (again.tries - 1)), kLongestPause);
    files.note(fmt::format("tried {} of {} times, again in {:.0f} s", again.tries, kMostTries,
                           std::chrono::duration<double>(pause).count()));
    files.refresh(record.status);
    again.waits = true;
    again.timer.expires_after(pause);
    again.timer.async_wait(whileAlive([this, number = record.number](const std::error_code& code) {
        const auto entry = again_.find(number);
        if (code || entry == again_.end()) return;
        entry->second.waits = false;
        scheduleSoon();
    }));
    --record.attempts;
    record.handle.clear();
    record.status.set_state(State::QUEUED);
    record.status.set_progress(0);
    tellWhyItWaits(record, Error{ErrorCode::resourceExhausted, "", why});
    static_cast<void>(changed(record));
}

/// It goes on to be one that runs: nobody knows better, and it is not begun a second time.
void JobQueue::lookWhenPossible(JobRecord& record, std::optional<RunEnd> end, const Error& why) {
    unsure_.insert_or_assign(record.number, Unsure{isFilm(record), std::move(end)});
    tellWhyItWaits(record, why);
    lookAgainLater();
}

void JobQueue::lookAtUnsure() {
    for (const auto& [number, unsure] : std::exchange(unsure_, {})) {
        auto* record = table_->find(number);
        if (!record) continue;
        if (!unsure.end) {
            goOnWith(*record);
            continue;
        }
        JobFiles files(directoryOf(*record));
        files.refresh(record->status);
        conclude(*record, files, *unsure.end);
    }
}

void JobQueue::tellWhyItWaits(JobRecord& record, const Error& why) {
    const auto sentence = plainText(why.toString(), 200);
    if (record.status.waits_for() == sentence) return;
    record.status.set_phase("waiting: " + sentence);
    record.status.set_waits_for(sentence);
    tell(record);
}

Status JobQueue::changed(const JobRecord& record) {
    const auto saved = table_->save(record);
    if (saved.ok()) {
        holdFor_ = {};
        tell(record);
    } else {
        hold(saved.error());
    }
    return saved;
}

}  // namespace mote::server
