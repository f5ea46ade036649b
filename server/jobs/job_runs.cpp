// SPDX-License-Identifier: GPL-3.0-or-later
//
// A queue's jobs from their start to their end.
#include <fmt/format.h>
#include <signal.h>
#include <string.h>
#include <sysexits.h>

#include <algorithm>
#include <asio/post.hpp>
#include <chrono>
#include <utility>

#include "server/jobs/artifact_files.h"
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

/// `ranks`: it was started by mpirun.
std::string sentenceOf(const JobFiles::Outcome& outcome, const JobRecord& record, bool ranks = false) {
    if (outcome.timedOut) return fmt::format("ran longer than its time limit of {} s", outcome.number);
    if (outcome.signalled) return endedBySignal(record, outcome.number);
    // Its last line says why, as programs do: "mote-prep: WHERE: WHAT".
    const auto self = programOf(record) + ": ";
    const auto isOwn = [&](const std::string& line) { return line.starts_with(self); };
    const auto& log = record.status.log();
    // Of several ranks, of which none says more than its error, mpirun has the last word.
    auto why = log.rbegin();
    if (ranks) why = std::find_if(log.rbegin(), log.rend(), isOwn);
    if (why == log.rend()) why = log.rbegin();
    if (why != log.rend()) return isOwn(*why) ? why->substr(self.size()) : *why;
    return fmt::format("{} ended with exit code {} and no message", programOf(record), outcome.number);
}

/// Whoever runs it says why it was ended: the signal is no fault of its own.
bool isTaken(const JobFiles::Outcome& outcome, const RunEnd& end) {
    return outcome.signalled && !end.how.empty();
}

}  // namespace

// ---------------------------------------------------------------------------------------- running jobs

void JobQueue::scheduleSoon() {
    if (std::exchange(scheduling_, true)) return;
    asio::post(context_, whileAlive([this] { schedule(); }));
}

void JobQueue::schedule() {
    scheduling_ = false;
    if (!table_ || held_) return;
    for (const auto& forgotten : table_->prune(settings_.kept)) discard(forgotten, directoryOf(forgotten));
    lookForRoots();
    for (const bool film : {false, true}) {
        const auto slots = film ? kFilms : settings_.running;
        if (activeCount(film) >= slots) continue;
        for (auto* record : table_->queued(film)) {
            if (held_ || activeCount(film) >= slots) break;
            if (starting_.contains(record->number)) continue;
            if (const auto again = again_.find(record->number); again != again_.end() && again->second.waits)
                continue;
            if (const auto* missing = missingRoot(*record)) {
                waitAlone(*record, *missing);
            } else {
                begin(*record);
            }
        }
    }
}

std::size_t JobQueue::activeCount(bool film) const {
    const auto running = std::count_if(active_.begin(), active_.end(),
                                       [&](const auto& entry) { return entry.second.film == film; });
    const auto starting = std::count_if(starting_.begin(), starting_.end(),
                                        [&](const auto& entry) { return entry.second == film; });
    // They may run as well as not.
    const auto unsure = std::count_if(unsure_.begin(), unsure_.end(), [&](const auto& entry) {
        return !entry.second.end && entry.second.film == film;
    });
    return static_cast<std::size_t>(running + starting + unsure);
}

void JobQueue::begin(JobRecord& record) {
    const auto output = placeOf(record);
    if (!output.ok()) return cannotBegin(record, output.error());
    JobFiles files(directoryOf(record));
    const auto order = prepare(record, files, *output);
    // The state directory's, whatever it is.
    if (!order.ok()) return waitForPlace(record, order.error());
    const auto number = record.number;
    starting_.emplace(number, isFilm(record));
    runnerOf(record).start(*order, [this, number, alive = std::weak_ptr(alive_)](auto run) {
        if (!alive.expired()) begun(number, std::move(run));
    });
}

/// The run waits for go(). It may have been cancelled meanwhile.
void JobQueue::begun(std::int64_t number, Result<std::unique_ptr<Run>> run) {
    starting_.erase(number);
    auto* record = table_ ? table_->find(number) : nullptr;
    if (!record) return;
    if (record->status.state() != State::QUEUED) return scheduleSoon();
    if (!run.ok()) {
        // A log or a program that may not be opened is not this job's alone.
        const bool denied = run.error().code == ErrorCode::permissionDenied;
        return denied ? waitForPlace(*record, run.error()) : cannotBegin(*record, run.error());
    }
    const JobRecord before = *record;
    ++record->attempts;
    record->handle = (*run)->handle();
    auto& status = record->status;
    status.set_state(State::RUNNING);
    status.set_runner(isFilm(*record) ? "local" : settings_.runner);
    status.set_runner_id((*run)->id());
    status.set_started_ms(nowMs());
    status.set_progress(0);
    status.set_phase("starting");
    status.clear_waits_for();
    // Only now that its handle is stored may it begin: no job ever runs that a restarted server would not
    // find.
    if (const auto saved = table_->save(*record); !saved.ok()) {
        *record = before;
        return waitForPlace(*record, saved.error());
    }
    (*run)->go();
    holdFor_ = {};
    tell(*record);
    watch(number, {JobFiles(directoryOf(*record)), *std::move(run), isFilm(*record)});
}

/// Two kinds of errors are the place's, and no fault of the job: what is used up no job has, and where this
/// one may not make its output others may.
void JobQueue::cannotBegin(JobRecord& record, const Error& error) {
    if (error.code == ErrorCode::resourceExhausted) return waitForPlace(record, error);
    if (error.code == ErrorCode::permissionDenied) return waitAlone(record, error);
    ++record.attempts;
    finish(record, State::FAILED, error.toString());
}

/// Where its output is to lie; empty where it stays with the job.
Result<std::filesystem::path> JobQueue::placeOf(const JobRecord& record) const {
    if (keepsFiles(record)) return std::filesystem::path();
    const auto output = findOutput(record.status.request(), roots_);
    if (!output.ok()) return Error{output.error().code, "output", output.error().toString()};
    return output->path;
}

Result<RunOrder> JobQueue::prepare(const JobRecord& record, JobFiles& files,
                                   const std::filesystem::path& output) const {
    const auto& directory = files.directory();
    RunOrder order;
    if (keepsFiles(record)) {
        std::error_code code;
        // An export begins anew; of a film goes on what is there.
        if (!isFilm(record)) std::filesystem::remove_all(artifactFolder(directory), code);
        MOTE_RETURN_IF_ERROR(files.prepareArtifact());
        order = isFilm(record) ? filmOrder(settings_, directory) : exportOrder(settings_, roots_, directory);
    } else {
        MOTE_RETURN_IF_ERROR(files.prepare(record.status.request(), output));
        order = prepOrder(settings_, roots_, directory, ranksOf(settings_, record.status.request()));
        if (!order.scratch.empty()) MOTE_RETURN_IF_ERROR(files.makeScratch(order.scratch));
    }
    order.timeLimit = record.status.time_limit_s();
    return order;
}

void JobQueue::watch(std::int64_t number, Active active) {
    auto& run = *active_.insert_or_assign(number, std::move(active)).first->second.run;
    run.onEnd(whileAlive([this, number](const RunEnd& how) { end(number, how); }));
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
        tell(*record);  // how far it is, the job's own files know
    }
    watchSoon();
}

// ----------------------------------------------------------------------------------------- ended jobs

void JobQueue::end(std::int64_t number, const RunEnd& how) {
    auto active = active_.extract(number);
    auto* record = table_ ? table_->find(number) : nullptr;
    if (active.empty() || !record) return;
    active.mapped().files.refresh(record->status);
    conclude(*record, active.mapped().files, how);
    scheduleSoon();
}

/// Nothing of the job runs any more: what came of it?
void JobQueue::conclude(JobRecord& record, JobFiles& files, const RunEnd& end) {
    const auto read = files.outcome();
    if (!read.ok()) return lookWhenPossible(record, end, read.error());
    if (keepsFiles(record)) return concludeArtifact(record, files, *read, end);
    const auto output = findOutput(record.status.request(), roots_);
    // Its output may well be there.
    if (!output.ok() && output.error().code == ErrorCode::resourceExhausted)
        return lookWhenPossible(record, end, output.error());
    const auto& outcome = *read;
    const bool there = output.ok() && output.value().exists;
    const bool clean = outcome && !outcome->signalled && !outcome->timedOut;
    if (output.ok()) discardDraft(output->path, record.status.id());
    if (there && !(clean && outcome->number != 0)) return finish(record, State::SUCCEEDED);
    if (record.cancelRequested) return finish(record, State::CANCELLED);
    if (!outcome || isTaken(*outcome, end)) return lost(record, files, end);
    if (clean && outcome->number == EX_TEMPFAIL) return tryLater(record, files, sentenceOf(*outcome, record));
    lookForRoots();
    if (const auto* missing = missingRoot(record)) {
        // What it made is seen with the folder.
        if (clean && outcome->number == 0) return lookWhenPossible(record, end, *missing);
        return interrupted(record, files, "a folder of data went away");
    }
    if (clean && outcome->number == 0) {
        return finish(record, State::FAILED, "mote-prep ended without an error, but its output is not there");
    }
    const bool ranks = ranksOf(settings_, record.status.request()) > 1;
    finish(record, State::FAILED, sentenceOf(*outcome, record, ranks));
}

/// A film that was ended by a signal goes on where it was, too.
void JobQueue::concludeArtifact(JobRecord& record, JobFiles& files,
                                const std::optional<JobFiles::Outcome>& outcome, const RunEnd& end) {
    if (record.cancelRequested) return finish(record, State::CANCELLED);
    if (!outcome || isTaken(*outcome, end)) return lost(record, files, end);
    if (outcome->signalled) return interrupted(record, files, endedBySignal(record, outcome->number));
    if (!outcome->timedOut && outcome->number == EX_TEMPFAIL)
        return tryLater(record, files, sentenceOf(*outcome, record));
    if (outcome->number != 0) return finish(record, State::FAILED, sentenceOf(*outcome, record));
    if (artifactIsThere(files.directory(), record.status.request())) return finish(record, State::SUCCEEDED);
    finish(record, State::FAILED,
           fmt::format("{} ended without an error, but its {} is not there", programOf(record),
                       isFilm(record) ? "film" : "export"));
}

/// Nobody knows how its program ended.
void JobQueue::lost(JobRecord& record, JobFiles& files, const RunEnd& end) {
    if (!end.again) return finish(record, State::FAILED, end.how);
    interrupted(record, files, end.how.empty() ? kTaken : end.how);
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
    log::warn(log::job(record.status.id()), "interrupted and queued again");
    record.handle.clear();
    record.status.set_state(State::QUEUED);
    record.status.set_interrupted(record.status.interrupted() + 1);
    record.status.set_progress(0);
    record.status.set_phase("waiting again: it was interrupted");
    static_cast<void>(changed(record));
}

void JobQueue::finish(JobRecord& record, proto::JobStatus::State state, std::string error) {
    again_.erase(record.number);
    record.handle.clear();
    record.status.set_state(state);
    record.status.set_error(plainText(error, 1000));
    record.status.set_finished_ms(nowMs());
    if (state == State::SUCCEEDED) record.status.set_progress(1);
    if (state == State::SUCCEEDED && !keepsFiles(record)) record.made = madeBy(record);
    record.status.set_phase("");
    record.status.clear_waits_for();
    log::info(log::job(record.status.id()), "ended: {}",
              state == State::SUCCEEDED   ? "succeeded"
              : state == State::CANCELLED ? "cancelled"
                                          : "failed: " + record.status.error());
    // Until its end is stored, its files tell the next server of it.
    if (changed(record).ok()) clearAway(record);
    scheduleSoon();
}

/// The store keeps the log's end, but no request of a film or an export, which may be tried again.
void JobQueue::clearAway(const JobRecord& record) {
    const JobFiles files(directoryOf(record));
    if (readsUploads(record.status.request())) removeSoon(uploads_ / record.status.id());
    if (!keepsFiles(record)) return files.remove();
    files.removeRest();
    if (!hasFiles(record)) discard(record, artifactFolder(files.directory()));
}

}  // namespace mote::server
