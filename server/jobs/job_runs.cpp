// SPDX-License-Identifier: GPL-3.0-or-later
//
// A queue's jobs from their start to their end.
#include <fmt/format.h>
#include <signal.h>
#include <string.h>

#include <algorithm>
#include <asio/post.hpp>
#include <chrono>
#include <utility>

#include "server/jobs/film_files.h"
#include "server/jobs/job_queue.h"
#include "server/jobs/job_request_check.h"
#include "server/jobs/run_orders.h"
#include "server/log.h"

namespace mote::server {
namespace {

using State = proto::JobStatus;

constexpr std::chrono::milliseconds kLookEvery(200);  // at what running jobs have written
constexpr std::size_t kFilms = 1;                     // that may run at a time, beside the other jobs
constexpr const char* kTaken = "its process was killed, or the machine went down";

/// Interrupted that often, a job fails. A film goes on where it was, and may take days.
int mostAttempts(const JobRecord& record) {
    return isFilm(record) ? 10 : 2;
}

std::string programOf(const JobRecord& record) {
    return isFilm(record) ? "mote-frames" : "mote-prep";
}

std::string endedBySignal(const JobRecord& record, int number) {
    const char* hint = number == SIGKILL ? "; perhaps memory ran out" : "";
    return fmt::format("{} was ended by signal {} ({}){}", programOf(record), number, strsignal(number),
                       hint);
}

std::string sentenceOf(const JobFiles::Outcome& outcome, const JobRecord& record) {
    if (outcome.signalled) return endedBySignal(record, outcome.number);
    // Its last line says why, as programs do: "mote-prep: WHERE: WHAT".
    const auto self = programOf(record) + ": ";
    const auto& log = record.status.log();
    if (!log.empty()) {
        const auto& last = *log.rbegin();
        return last.starts_with(self) ? last.substr(self.size()) : last;
    }
    return fmt::format("{} ended with exit code {} and no message", programOf(record), outcome.number);
}

}  // namespace

// ---------------------------------------------------------------------------------------- running jobs

void JobQueue::scheduleSoon() {
    if (std::exchange(scheduling_, true)) return;
    asio::post(context_, whileAlive([this] { schedule(); }));
}

void JobQueue::schedule() {
    scheduling_ = false;
    if (!table_) return;
    for (const auto& forgotten : table_->prune(settings_.kept)) discard(forgotten);
    for (const bool film : {false, true}) {
        while (activeCount(film) < (film ? kFilms : settings_.running)) {
            auto* record = table_->nextQueued(film);
            if (!record) break;
            begin(*record);
        }
    }
}

std::size_t JobQueue::activeCount(bool film) const {
    return static_cast<std::size_t>(std::count_if(
        active_.begin(), active_.end(), [&](const auto& entry) { return entry.second.film == film; }));
}

void JobQueue::begin(JobRecord& record) {
    ++record.attempts;
    record.handle.clear();
    record.status.set_state(State::RUNNING);
    record.status.set_started_ms(nowMs());
    record.status.set_progress(0);
    record.status.set_phase("starting");
    Active active{JobFiles(directoryOf(record)), nullptr, isFilm(record)};
    const auto order = prepare(record, active.files);
    if (!order.ok()) return finish(record, State::FAILED, order.error().toString());
    auto run = runner_->start(*order);
    if (!run.ok()) return finish(record, State::FAILED, run.error().toString());
    active.run = *std::move(run);
    record.handle = active.run->handle();
    changed(record);
    // Only now that its handle is stored may it begin: no job ever runs that a restarted server would not
    // find.
    active.run->go();
    watch(record.number, std::move(active));
}

Result<RunOrder> JobQueue::prepare(const JobRecord& record, JobFiles& files) const {
    if (isFilm(record)) {
        MOTE_RETURN_IF_ERROR(files.prepareFilm());
        return filmOrder(settings_, files.directory());
    }
    const auto output = findOutput(record.status.request(), roots_);
    if (!output.ok()) return Error{output.error().code, "output", output.error().toString()};
    MOTE_RETURN_IF_ERROR(files.prepare(record.status.request()));
    return prepOrder(settings_, roots_, files.directory(), output.value().root);
}

void JobQueue::watch(std::int64_t number, Active active) {
    auto& run = *active_.insert_or_assign(number, std::move(active)).first->second.run;
    run.onEnd(whileAlive([this, number] { end(number); }));
    watchSoon();
}

/// A timer, and not inotify: it limits the rate as well, works on network file systems, and runs only while
/// jobs do.
void JobQueue::watchSoon() {
    if (active_.empty() || std::exchange(looking_, true)) return;
    timer_.expires_after(kLookEvery);
    timer_.async_wait(whileAlive([this](const std::error_code& code) {
        looking_ = false;
        if (!code) look();
    }));
}

void JobQueue::look() {
    for (auto& [number, active] : active_) {
        auto* record = table_->find(number);
        MOTE_CHECK(record);
        if (!active.files.refresh(record->status)) continue;
        if (record->cancelRequested) record->status.set_phase("cancelling");
        changed(*record);
    }
    watchSoon();
}

// ----------------------------------------------------------------------------------------- ended jobs

void JobQueue::end(std::int64_t number) {
    auto active = active_.extract(number);
    auto* record = table_ ? table_->find(number) : nullptr;
    if (active.empty() || !record) return;
    active.mapped().files.refresh(record->status);
    conclude(*record, active.mapped().files);
    scheduleSoon();
}

/// Nothing of the job runs any more: what came of it?
void JobQueue::conclude(JobRecord& record, JobFiles& files) {
    if (isFilm(record)) return concludeFilm(record, files);
    const auto outcome = files.outcome();
    const auto output = findOutput(record.status.request(), roots_);
    const bool there = output.ok() && output.value().exists;
    const bool clean = outcome && !outcome->signalled;
    if (!clean && output.ok()) removeDrafts(output.value());
    if (there && !(clean && outcome->number != 0)) return finish(record, State::SUCCEEDED);
    if (record.cancelRequested) return finish(record, State::CANCELLED);
    if (!outcome) return interrupted(record, files, kTaken);
    if (clean && outcome->number == 0) {
        return finish(record, State::FAILED, "mote-prep ended without an error, but its output is not there");
    }
    finish(record, State::FAILED, sentenceOf(*outcome, record));
}

/// A film that was ended by a signal goes on where it was, too.
void JobQueue::concludeFilm(JobRecord& record, JobFiles& files) {
    if (record.cancelRequested) return finish(record, State::CANCELLED);
    const auto outcome = files.outcome();
    if (!outcome) return interrupted(record, files, kTaken);
    if (outcome->signalled) return interrupted(record, files, endedBySignal(record, outcome->number));
    if (outcome->number != 0) return finish(record, State::FAILED, sentenceOf(*outcome, record));
    if (filmIsThere(files.directory(), record.status.request().film()))
        return finish(record, State::SUCCEEDED);
    finish(record, State::FAILED, "mote-frames ended without an error, but its film is not there");
}

/// It was ended by others: the machine or someone's kill took it, not a fault of its own. Again, but not for
/// ever.
void JobQueue::interrupted(JobRecord& record, JobFiles& files, const std::string& how) {
    if (record.attempts >= mostAttempts(record)) {
        const auto often = record.attempts == 2 ? "twice" : fmt::format("{} times", record.attempts);
        return finish(record, State::FAILED,
                      fmt::format("was interrupted {} ({}): submit it again", often, how));
    }
    files.note("interrupted: queued again");
    files.refresh(record.status);
    log::warn("job {} was interrupted and is queued again", record.status.id());
    record.handle.clear();
    record.status.set_state(State::QUEUED);
    record.status.set_progress(0);
    record.status.set_phase("waiting again: it was interrupted");
    changed(record);
}

void JobQueue::finish(JobRecord& record, proto::JobStatus::State state, std::string error) {
    record.handle.clear();
    record.status.set_state(state);
    record.status.set_error(plainText(error, 1000));
    record.status.set_finished_ms(nowMs());
    if (state == State::SUCCEEDED) record.status.set_progress(1);
    record.status.set_phase("");
    log::info("job {} {}", record.status.id(),
              state == State::SUCCEEDED   ? "succeeded"
              : state == State::CANCELLED ? "was cancelled"
                                          : "failed: " + record.status.error());
    changed(record);
    // The store keeps the log's end.
    if (keepsFilm(record)) {
        JobFiles(directoryOf(record)).removeRest();
    } else {
        discard(record);
    }
    scheduleSoon();
}

}  // namespace mote::server
