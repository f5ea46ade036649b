// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which jobs are the same, which are done again, who runs them, and pages of them all.
#include <fmt/format.h>

#include <algorithm>

#include "protocol/scene/json.h"
#include "server/jobs/job_queue.h"
#include "server/jobs/job_request_check.h"
#include "server/jobs/request_digest.h"
#include "server/jobs/runner_check.h"
#include "server/jobs/slurm_runner.h"
#include "server/log.h"

namespace mote::server {
namespace {

using State = proto::JobStatus;

constexpr std::uint32_t kMostOfPage = 200;

}  // namespace

/// The server's is never exceeded.
std::uint32_t JobQueue::timeLimitOf(const JobWish& wish) const {
    if (wish.timeLimit == 0 || settings_.timeLimit == 0) return std::max(wish.timeLimit, settings_.timeLimit);
    return std::min(wish.timeLimit, settings_.timeLimit);
}

/// The identity of its dataset or file; empty: it is not there.
std::string JobQueue::madeBy(const JobRecord& record) const {
    const auto output = findOutput(record.status.request(), roots_);
    return output.ok() && output->exists ? identityOf(output->path) : std::string();
}

bool JobQueue::isStillThere(const JobRecord& record) const {
    if (record.status.state() != State::SUCCEEDED) return false;
    if (keepsFiles(record)) return artifactIsThere(directoryOf(record), record.status.request());
    return !record.made.empty() && madeBy(record) == record.made;
}

/// What the same request has come to, if that is of any use: it waits, runs, or has made what is still there.
const JobRecord* JobQueue::sameJob(const std::string& digest) const {
    if (digest.empty()) return nullptr;
    return table_->latest(digest, [this](const JobRecord& record) {
        return isLive(record) ? !record.cancelRequested : isStillThere(record);
    });
}

Result<proto::JobStatus> JobQueue::retry(std::string_view id, const std::string& client) {
    const auto* record = table_ ? table_->find(id) : nullptr;
    if (!record) return Error{ErrorCode::notFound, "id", fmt::format("there is no job \"{}\"", id)};
    const auto state = record->status.state();
    if (state != State::FAILED && state != State::CANCELLED) {
        return Error{ErrorCode::invalidArgument, "id",
                     fmt::format("job {} {}: only what failed or was cancelled is tried again", id,
                                 state == State::SUCCEEDED ? "succeeded" : "has not ended")};
    }
    auto request = record->status.request();
    // Its status holds no script and no large selection.
    if (keepsFiles(*record)) {
        request.Clear();
        const auto read = readJsonFile(directoryOf(*record) / "request.json", request);
        if (!read.ok()) {
            return Error{ErrorCode::notFound, "id",
                         fmt::format("the request of job {} is not there any more: submit it anew", id)};
        }
    }
    if (readsUploads(request)) {
        return Error{
            ErrorCode::notFound, "id",
            fmt::format("what job {} read was uploaded for it and went with it: upload it and submit "
                        "it anew",
                        id)};
    }
    return submit(request, {false, record->status.time_limit_s(), client});
}

proto::Jobs JobQueue::page(std::uint64_t first, std::uint32_t count) const {
    proto::Jobs page;
    if (!table_) return page;
    const auto most = count == 0 ? kMostOfPage : std::min(count, kMostOfPage);
    for (auto& status : table_->page(first, most)) *page.add_jobs() = std::move(status);
    page.set_total(table_->size());
    page.set_first(first);
    return page;
}

// ------------------------------------------------------------------------------------------- runners

Status JobQueue::openRunners() {
    MOTE_RETURN_IF_ERROR(checkRunner(settings_.runner, settings_.ranks));
    local_ = makeLocalRunner(context_, settings_.supervisor);
    return settings_.runner == "slurm" || findsRunsOfSlurm() ? openSlurm() : success();
}

/// Runs of Slurm are found again by a server that runs its jobs otherwise now; where there is no Slurm any
/// more, they are lost, and the server is not.
bool JobQueue::findsRunsOfSlurm() {
    const auto all = table_->all();
    const bool known =
        std::ranges::any_of(all, [](const auto* record) { return isSlurmHandle(record->handle); });
    if (!known) return false;
    const auto there = checkRunner("slurm", 1);
    if (!there.ok()) log::warn("jobs that run in Slurm are lost: {}", there.error().toString());
    return there.ok();
}

Status JobQueue::openSlurm() {
    MOTE_ASSIGN_OR_RETURN(slurm_, makeSlurmRunner(context_, settings_));
    std::vector<std::string> waiting;
    for (const auto* record : table_->all()) {
        if (record->status.state() == State::QUEUED) waiting.push_back(record->status.id());
    }
    slurm_->forget(waiting);
    return success();
}

Runner& JobQueue::runnerOf(const JobRecord& record) const {
    return settings_.runner == "slurm" && !isFilm(record) ? *slurm_ : *local_;
}

/// Nothing where it is not found.
Result<std::unique_ptr<Run>> JobQueue::findRun(std::string_view handle) const {
    if (!isSlurmHandle(handle)) return local_->find(handle);
    if (!slurm_) return std::unique_ptr<Run>();
    return slurm_->find(handle);
}

/// Of a run that was not found. Where nobody can be asked it may still run: it is not begun a second time.
RunEnd JobQueue::endOfLost(std::string_view handle) const {
    if (!isSlurmHandle(handle) || slurm_) return {};
    return {"ran in Slurm, of which the server finds nothing any more: look there whether it still runs",
            false};
}

}  // namespace mote::server
