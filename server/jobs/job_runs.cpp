// SPDX-License-Identifier: GPL-3.0-or-later
//
// What happens to a queue's jobs, from their turn to their end. What follows from it JobLife says.
#include <fmt/format.h>
#include <signal.h>
#include <string.h>
#include <sysexits.h>

#include <algorithm>
#include <asio/post.hpp>
#include <chrono>
#include <utility>

#include "protocol/base/utf8.h"
#include "protocol/scene/job_request.h"
#include "server/jobs/job_queue.h"
#include "server/jobs/run_orders.h"
#include "server/log.h"

namespace mote::server {
namespace {

using State = proto::JobStatus;
using Stage = JobLife::Stage;

constexpr std::chrono::milliseconds kLookEvery(200);  // at what running jobs have written
constexpr std::chrono::milliseconds kShortHold(500), kLongHold(30000), kLongestRest(300'000);
constexpr std::size_t kFilms = 1;  // that may run at a time, beside the other jobs
constexpr const char* kTaken = "its process was killed, or the machine went down";

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

State::State stateOf(Stage stage) {
    switch (stage) {
        case Stage::succeeded:
            return State::SUCCEEDED;
        case Stage::failed:
            return State::FAILED;
        case Stage::cancelled:
            return State::CANCELLED;
        case Stage::runs:
        case Stage::unsure:
        case Stage::over:
            return State::RUNNING;
        default:
            return State::QUEUED;
    }
}

/// Of a job that neither waits nor runs.
Stage lastStageOf(const JobRecord& record) {
    if (record.status.state() == State::SUCCEEDED) return Stage::succeeded;
    return record.status.state() == State::CANCELLED ? Stage::cancelled : Stage::failed;
}

}  // namespace

// ---------------------------------------------------------------------------------- what follows from what

JobLife JobQueue::lifeOf(const JobRecord& record) const {
    const auto live = live_.find(record.number);
    JobLife life;
    life.stage = live != live_.end() ? live->second.stage : lastStageOf(record);
    life.roomless = live != live_.end() ? live->second.roomless : 0;
    life.keepsFiles = keepsFiles(record);
    life.cancelled = record.cancelRequested;
    life.mostAttempts = isFilm(record) ? 10 : 2;  // a film goes on where it was, and may take days
    life.attempts = record.attempts;
    life.interrupted = static_cast<int>(record.status.interrupted());
    return life;
}

/// `why`: a sentence, where something is at fault.
void JobQueue::happens(JobRecord& record, JobEvent event, const std::string& why) {
    const auto before = lifeOf(record);
    const auto step = next(before, event, why);
    const auto& life = step.life;
    record.cancelRequested = life.cancelled;
    record.attempts = life.attempts;
    record.status.set_interrupted(static_cast<std::uint32_t>(life.interrupted));
    if (!isLive(life.stage)) {
        if (life != before) finish(record, step);
        return;
    }
    auto& live = live_.at(record.number);
    live.stage = life.stage;
    live.roomless = life.roomless;
    if (before.stage == Stage::over && life.stage != Stage::over) {
        waitAgain(record, life, why);
    } else if (!why.empty()) {
        tellWhyItWaits(record, why);
    }
    for (const auto deed : step.deeds) perform(deed, record, why);
}

void JobQueue::perform(JobDeed deed, JobRecord& record, const std::string& why) {
    switch (deed) {
        case JobDeed::start:
            return begin(record);
        case JobDeed::go:
            live_.at(record.number).run->go();
            return watch(record);
        case JobDeed::watch:
            return watch(record);
        case JobDeed::stop:
            return live_.at(record.number).run->cancel();
        case JobDeed::look:
            return conclude(record);
        case JobDeed::lookLater:
            return lookAgainLater();
        case JobDeed::hold:
            return hold(why);
        case JobDeed::drop:   // nobody has kept the run
        case JobDeed::rest:   // waitAgain() began it
        case JobDeed::clear:  // finish() does, when its end is stored
            break;
    }
}

/// It keeps its place in the queue; others go before it while it rests.
void JobQueue::waitAgain(JobRecord& record, const JobLife& life, const std::string& why) {
    auto& live = live_.at(record.number);
    const bool rests = life.stage == Stage::pauses;
    if (rests) {
        const auto pause = std::min(settings_.placePause * (1 << (life.roomless - 1)), kLongestRest);
        live.files.note(fmt::format("tried {} of {} times, again in {:.0f} s", life.roomless, mostRoomless,
                                    std::chrono::duration<double>(pause).count()));
        live.rest.emplace(context_);
        live.rest->expires_after(pause);
        live.rest->async_wait(whileAlive([this, number = record.number](const std::error_code& code) {
            if (code || !live_.contains(number)) return;
            happens(*table_->find(number), JobEvent::rested);
            scheduleSoon();
        }));
    } else {
        live.files.note("interrupted: queued again");
        log::warn(log::job(record.status.id()), "interrupted and queued again");
    }
    live.files.refresh(record.status);
    record.handle.clear();
    record.status.set_state(State::QUEUED);
    record.status.set_progress(0);
    if (rests) {
        tellWhyItWaits(record, why);
    } else {
        record.status.set_phase("waiting again: it was interrupted");
    }
    static_cast<void>(changed(record));
}

void JobQueue::finish(JobRecord& record, const JobStep& last) {
    live_.erase(record.number);
    const auto state = stateOf(last.life.stage);
    record.handle.clear();
    record.status.set_state(state);
    record.status.set_error(plainText(last.error, 1000));
    const bool thrownAway = state == State::SUCCEEDED && keepsFiles(record) && record.cancelRequested;
    if (!thrownAway) record.status.set_finished_ms(unixMs());
    if (state == State::SUCCEEDED) record.status.set_progress(1);
    if (state == State::SUCCEEDED && !keepsFiles(record))
        record.made = identityOfOutput(record.status.request(), roots_);
    record.status.set_phase(thrownAway ? "thrown away" : "");
    record.status.clear_waits_for();
    log::info(log::job(record.status.id()), "ended: {}",
              thrownAway                  ? "what it made was thrown away"
              : state == State::SUCCEEDED ? "succeeded"
              : state == State::CANCELLED ? "cancelled"
                                          : "failed: " + record.status.error());
    // Until its end is stored, its files tell the next server of it.
    if (changed(record).ok()) clearAway(record);
    scheduleSoon();
}

/// The store keeps the log's end, but no request of a film or an export, which may be tried again.
void JobQueue::clearAway(const JobRecord& record) {
    const JobFiles files(directoryOf(record));
    if (readsUploads(record.status.request())) disk_.remove(uploads_ / record.status.id());
    if (!keepsFiles(record)) return files.remove();
    files.removeRest();
    if (!hasFiles(record)) discard(record, artifactFolder(files.directory()));
}

/// A film may be thousands of files: nobody waits until they are gone. So named the folder is no job's,
/// and should this server end first, the next one removes the rest.
void JobQueue::discard(const JobRecord& record, const std::filesystem::path& folder) {
    const std::filesystem::path gone = directoryOf(record).string() + ".gone";
    std::error_code code;
    std::filesystem::rename(folder, gone, code);
    disk_.remove(code ? folder : gone);
}

// -------------------------------------------------------------------------------------------- to begin

void JobQueue::scheduleSoon() {
    if (std::exchange(scheduling_, true)) return;
    asio::post(context_, whileAlive([this] { schedule(); }));
}

void JobQueue::schedule() {
    scheduling_ = false;
    if (!table_ || held_) return;
    for (const auto& forgotten : table_->prune(settings_.kept)) discard(forgotten, directoryOf(forgotten));
    rootWatch_.look();
    for (const bool film : {false, true}) {
        const auto places = film ? kFilms : settings_.running;
        if (placesTaken(film) >= places) continue;
        for (auto* record : table_->queued(film)) {
            if (held_ || placesTaken(film) >= places) break;
            if (lifeOf(*record).stage != Stage::waits || waitsItsTurn(*record)) continue;
            if (const auto* missing = rootWatch_.missing(record->status.request())) {
                happens(*record, JobEvent::denied, missing->toString());
            } else {
                happens(*record, JobEvent::chosen);
            }
        }
    }
}

std::size_t JobQueue::placesTaken(bool film) {
    return static_cast<std::size_t>(std::ranges::count_if(live_, [&](const auto& entry) {
        return takesPlace(entry.second.stage) && isFilm(*table_->find(entry.first)) == film;
    }));
}

/// Steps of a live dataset become its in the order of their submission.
bool JobQueue::waitsItsTurn(const JobRecord& record) {
    const auto& request = record.status.request();
    return appendsSteps(request) && std::ranges::any_of(live_, [&](const auto& entry) {
               const auto& other = table_->find(entry.first)->status.request();
               return entry.first < record.number && other.output() == request.output();
           });
}

void JobQueue::begin(JobRecord& record) {
    std::filesystem::path output;
    if (!keepsFiles(record)) {
        const auto found = findOutput(record.status.request(), roots_);
        if (!found.ok())
            return cannotBegin(record, Error{found.error().code, "output", found.error().toString()});
        output = found->path;
    }
    const auto order = prepare(record, live_.at(record.number).files, output);
    // The state directory's, whatever it is.
    if (!order.ok()) return happens(record, JobEvent::held, order.error().toString());
    runners_->of(isFilm(record))
        .start(*order, whileAlive([this, number = record.number](Result<std::unique_ptr<Run>> run) {
            begun(number, std::move(run));
        }));
}

/// `output`: where it is to lie; empty where it stays with the job.
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
        order.grows = appendsSteps(record.status.request());
        if (!order.scratch.empty()) MOTE_RETURN_IF_ERROR(files.makeScratch(order.scratch));
    }
    order.timeLimit = record.status.time_limit_s();
    return order;
}

/// Two kinds of errors are the place's, and no fault of the job: what is used up no job has, and where this
/// one may not make its output others may.
void JobQueue::cannotBegin(JobRecord& record, const Error& error) {
    const auto event = error.code == ErrorCode::resourceExhausted  ? JobEvent::held
                       : error.code == ErrorCode::permissionDenied ? JobEvent::denied
                                                                   : JobEvent::refused;
    happens(record, event, error.toString());
}

/// The run waits for go(). The job may have been cancelled meanwhile: then it never begins.
void JobQueue::begun(std::int64_t number, Result<std::unique_ptr<Run>> run) {
    const auto live = live_.find(number);
    if (live == live_.end() || live->second.stage != Stage::starts) return scheduleSoon();
    auto& record = *table_->find(number);
    if (!run.ok()) {
        // A log or a program that may not be opened is not this job's alone.
        const bool denied = run.error().code == ErrorCode::permissionDenied;
        return denied ? happens(record, JobEvent::held, run.error().toString())
                      : cannotBegin(record, run.error());
    }
    const auto step = next(lifeOf(record), JobEvent::begun);
    JobRecord running = record;
    running.attempts = step.life.attempts;
    running.handle = (*run)->handle();
    auto& status = running.status;
    status.set_state(State::RUNNING);
    status.set_runner(isFilm(record) ? "local" : settings_.runner);
    status.set_runner_id((*run)->id());
    status.set_started_ms(unixMs());
    status.set_progress(0);
    status.set_phase("starting");
    status.clear_waits_for();
    // Only now that its handle is stored may it begin: no job ever runs that a restarted server would not
    // find.
    if (const auto saved = table_->save(running); !saved.ok())
        return happens(record, JobEvent::held, saved.error().toString());
    record = std::move(running);
    live->second.stage = step.life.stage;
    live->second.run = *std::move(run);
    live->second.files = JobFiles(directoryOf(record));
    holdFor_ = {};
    tell(record);
    for (const auto deed : step.deeds) perform(deed, record, {});
}

// ---------------------------------------------------------------------------------------- while it runs

void JobQueue::watch(JobRecord& record) {
    live_.at(record.number).run->onEnd(whileAlive([this, number = record.number](const RunEnd& how) {
        const auto live = live_.find(number);
        if (live == live_.end()) return;
        live->second.end = how;
        const auto ended = std::move(live->second.run);  // it is what calls
        happens(*table_->find(number), JobEvent::gone);
        scheduleSoon();
    }));
    lookSoon();
}

/// A timer, and not inotify: it limits the rate as well, works on network file systems, and runs only while
/// jobs do.
void JobQueue::lookSoon() {
    const auto runs = [](const auto& entry) { return entry.second.run != nullptr; };
    if (std::ranges::none_of(live_, runs) || std::exchange(looking_, true)) return;
    progressTimer_.expires_after(kLookEvery);
    progressTimer_.async_wait(whileAlive([this](const std::error_code& code) {
        looking_ = false;
        if (!code) lookAtProgress();
    }));
}

void JobQueue::lookAtProgress() {
    for (auto& [number, live] : live_) {
        auto* record = table_->find(number);
        if (!live.run || !live.files.refresh(record->status)) continue;
        if (record->cancelRequested) record->status.set_phase("cancelling");
        tell(*record);  // how far it is, the job's own files know
    }
    lookSoon();
}

/// Its run, of this or an earlier server.
void JobQueue::seek(JobRecord& record) {
    record.status.clear_waits_for();
    auto run = runners_->find(record.handle);
    if (!run.ok()) return happens(record, JobEvent::hidden, run.error().toString());
    auto& live = live_.at(record.number);
    live.files.refresh(record.status);
    live.run = *std::move(run);
    if (!live.run) live.end = runners_->endOfLost(record.handle);
    if (live.run) log::info(log::job(record.status.id()), "still runs");
    happens(record, live.run ? JobEvent::found : JobEvent::gone);
}

// ----------------------------------------------------------------------------------------- at its end

/// Nothing of the job runs any more: what came of it?
void JobQueue::conclude(JobRecord& record) {
    auto& live = live_.at(record.number);
    live.files.refresh(record.status);
    const auto outcome = live.files.outcome();
    if (!outcome.ok()) return happens(record, JobEvent::hidden, outcome.error().toString());
    const auto [event, why] = keepsFiles(record) ? verdictOfArtifact(record, *outcome, live.end)
                                                 : verdictOfDataset(record, *outcome, live.end);
    happens(record, event, why);
}

JobQueue::Verdict JobQueue::verdictOfDataset(const JobRecord& record, const MaybeOutcome& outcome,
                                             const RunEnd& end) {
    const auto output = findOutput(record.status.request(), roots_);
    // Its output may well be there.
    if (!output.ok() && output.error().code == ErrorCode::resourceExhausted)
        return {JobEvent::hidden, output.error().toString()};
    const bool there = output.ok() && output->exists;
    const bool clean = outcome && !outcome->signalled && !outcome->timedOut;
    if (output.ok()) disk_.removeDraft(output->path, record.status.id());
    const bool well = clean && outcome->number == 0;
    // What steps are put in may have been there before them.
    const bool made = appendsSteps(record.status.request()) ? well : !clean || well;
    if (there && made) return {JobEvent::made};
    if (record.cancelRequested) return {JobEvent::broken, "it was cancelled"};
    if (!outcome || isTaken(*outcome, end)) return lostTo(end);
    if (clean && outcome->number == EX_TEMPFAIL) return {JobEvent::roomless, sentenceOf(*outcome, record)};
    rootWatch_.look();
    if (const auto* missing = rootWatch_.missing(record.status.request())) {
        // What it made is seen with the folder.
        if (clean && outcome->number == 0) return {JobEvent::hidden, missing->toString()};
        return {JobEvent::taken, "a folder of data went away"};
    }
    if (clean && outcome->number == 0)
        return {JobEvent::broken, "mote-prep ended without an error, but its output is not there"};
    const bool ranks = ranksOf(settings_, record.status.request()) > 1;
    return {JobEvent::broken, sentenceOf(*outcome, record, ranks)};
}

/// A film that was ended by a signal goes on where it was, too.
JobQueue::Verdict JobQueue::verdictOfArtifact(const JobRecord& record, const MaybeOutcome& outcome,
                                              const RunEnd& end) const {
    if (!outcome || isTaken(*outcome, end)) return lostTo(end);
    if (outcome->signalled) return {JobEvent::taken, endedBySignal(record, outcome->number)};
    if (!outcome->timedOut && outcome->number == EX_TEMPFAIL)
        return {JobEvent::roomless, sentenceOf(*outcome, record)};
    if (outcome->number != 0) return {JobEvent::broken, sentenceOf(*outcome, record)};
    if (artifactIsThere(directoryOf(record), record.status.request())) return {JobEvent::made};
    return {JobEvent::broken, fmt::format("{} ended without an error, but its {} is not there",
                                          programOf(record), isFilm(record) ? "film" : "export")};
}

/// Nobody knows how its program ended.
JobQueue::Verdict JobQueue::lostTo(const RunEnd& end) {
    if (!end.again) return {JobEvent::broken, end.how};
    return {JobEvent::taken, end.how.empty() ? kTaken : end.how};
}

// ------------------------------------------------------------------ what the place, and no job, is to blame
// for

void JobQueue::hold(const std::string& why) {
    if (std::exchange(held_, true)) return;
    if (holdFor_.count() == 0) log::warn("no job begins for now: {}", toLogText(why));
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
    std::vector<std::int64_t> hidden;
    for (const auto& [number, live] : live_)
        if (live.stage == Stage::unsure || live.stage == Stage::over) hidden.push_back(number);
    for (const auto number : hidden) {
        auto& record = *table_->find(number);
        live_.at(number).stage == Stage::unsure ? seek(record) : conclude(record);
    }
    const std::vector<std::int64_t> unsaved(table_->unsaved().begin(), table_->unsaved().end());
    for (const auto number : unsaved) {
        const auto* record = table_->find(number);
        if (record && changed(*record).ok() && !isLive(*record)) clearAway(*record);
    }
    scheduleSoon();
}

void JobQueue::tellWhyItWaits(JobRecord& record, const std::string& why) {
    const auto sentence = plainText(why, 200);
    if (record.status.waits_for() == sentence) return;
    record.status.set_phase("waiting: " + sentence);
    record.status.set_waits_for(sentence);
    tell(record);
}

Status JobQueue::changed(const JobRecord& record) {
    auto saved = table_->save(record);
    if (saved.ok()) {
        holdFor_ = {};
        tell(record);
    } else {
        hold(saved.error().toString());
    }
    return saved;
}

void JobQueue::tell(const JobRecord& record) {
    asio::post(context_, whileAlive([this, status = record.status] {
                   if (listener_) listener_(status);
               }));
}

}  // namespace mote::server
