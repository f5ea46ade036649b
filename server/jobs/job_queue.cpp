// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_queue.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <string.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>

#include <algorithm>
#include <asio/post.hpp>
#include <cerrno>
#include <chrono>
#include <thread>
#include <utility>

#include "protocol/scene/system_error.h"
#include "server/jobs/job_request_check.h"
#include "server/log.h"

namespace mote::server {
namespace {

using State = proto::JobStatus;

constexpr std::chrono::milliseconds kLookEvery(200);  // at what running jobs have written
constexpr std::chrono::milliseconds kLockPatience(500), kLockPause(5);
constexpr std::size_t kMostListed = 200;
constexpr int kMostAttempts = 2;

/// A server that was just killed keeps its lock until the kernel has taken it apart.
bool lockSoon(int file) {
    const auto end = std::chrono::steady_clock::now() + kLockPatience;
    while (flock(file, LOCK_EX | LOCK_NB) != 0) {
        if (std::chrono::steady_clock::now() >= end) return false;
        std::this_thread::sleep_for(kLockPause);
    }
    return true;
}

std::int64_t nowMs() {
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    return std::chrono::duration_cast<std::chrono::milliseconds>(now).count();
}

/// 16 hexadecimal digits that no earlier database has used.
std::string newId() {
    std::uint64_t bits = 0;
    MOTE_CHECK(getrandom(&bits, sizeof bits, 0) == static_cast<ssize_t>(sizeof bits));
    return fmt::format("{:016x}", bits);
}

std::string sentenceOf(const JobFiles::Outcome& outcome, const proto::JobStatus& status) {
    if (outcome.signalled) {
        const char* hint = outcome.number == SIGKILL ? "; perhaps memory ran out" : "";
        return fmt::format("mote-prep was ended by signal {} ({}){}", outcome.number,
                           strsignal(outcome.number), hint);
    }
    // Its last line says why, as programs do: "mote-prep: WHERE: WHAT".
    constexpr std::string_view self = "mote-prep: ";
    if (status.log_size() > 0) {
        const auto& last = status.log(status.log_size() - 1);
        return last.starts_with(self) ? last.substr(self.size()) : last;
    }
    return fmt::format("mote-prep ended with exit code {} and no message", outcome.number);
}

}  // namespace

JobQueue::JobQueue(asio::io_context& context, JobSettings settings)
    : context_(context), settings_(std::move(settings)), timer_(context) {}

// ------------------------------------------------------------------------------------------ begin and end

Status JobQueue::start() {
    MOTE_CHECK(!table_);
    MOTE_ASSIGN_OR_RETURN(roots_, storage::Roots::parse(settings_.roots));
    if (settings_.supervisor.empty()) settings_.supervisor = settings_.prep.parent_path() / "mote-supervise";
    settings_.running = std::max<std::size_t>(settings_.running, 1);
    MOTE_RETURN_IF_ERROR(openState());
    runner_ = makeLocalRunner(context_, settings_.supervisor, settings_.prep);
    goOn();
    scheduleSoon();
    return success();
}

Status JobQueue::openState() {
    std::error_code code;
    auto& state = settings_.stateDirectory;
    std::filesystem::create_directories(state.parent_path(), code);
    if (mkdir(state.c_str(), 0700) != 0 && errno != EEXIST) {
        return Error{ErrorCode::permissionDenied, state.string(),
                     fmt::format("cannot be made: {}", systemMessage(errno))};
    }
    state = std::filesystem::canonical(state, code);
    if (code || (mkdir((state / "jobs").c_str(), 0700) != 0 && errno != EEXIST)) {
        return Error{ErrorCode::permissionDenied, state.string(), "cannot hold the jobs' directories"};
    }
    lock_ = storage::FileDescriptor(open((state / "jobs.lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600));
    if (!lock_.valid()) {
        return Error{ErrorCode::permissionDenied, (state / "jobs.lock").string(), systemMessage(errno)};
    }
    if (!lockSoon(lock_.get())) {
        return Error{ErrorCode::alreadyExists, state.string(), "another server uses this state directory"};
    }
    MOTE_ASSIGN_OR_RETURN(auto store, JobStore::open(state / "jobs.sqlite"));
    const bool anew = !store.setAside().empty();
    JobTable table(std::move(store));
    MOTE_RETURN_IF_ERROR(table.load());
    table_.emplace(std::move(table));
    if (!anew)
        removeStrayDirectories();  // after a broken database they may still belong to something that runs
    return success();
}

void JobQueue::stop() {
    active_.clear();
    timer_.cancel();
    listener_ = nullptr;
    table_.reset();
    lock_ = {};
}

void JobQueue::removeStrayDirectories() {
    std::error_code code;
    std::vector<std::filesystem::path> strays;
    std::filesystem::directory_iterator entry(settings_.stateDirectory / "jobs", code);
    for (; !code && entry != std::filesystem::directory_iterator(); entry.increment(code)) {
        if (!table_->find(entry->path().filename().string())) strays.push_back(entry->path());
    }
    for (const auto& stray : strays) std::filesystem::remove_all(stray, code);
}

/// Takes up what an earlier server left.
void JobQueue::goOn() {
    for (auto* record : table_->all()) {
        if (record->status.state() == State::RUNNING) goOnWith(*record);
    }
}

void JobQueue::goOnWith(JobRecord& record) {
    Active active{JobFiles(directoryOf(record)), runner_->find(record.handle)};
    active.files.refresh(record.status);
    if (!active.run) return conclude(record, active.files);
    log::info("job {} still runs", record.status.id());
    if (record.cancelRequested) active.run->cancel();
    watch(record.number, std::move(active));
}

// ------------------------------------------------------------------------------------------- requests

Result<proto::JobStatus> JobQueue::submit(const proto::JobRequest& request) {
    if (!table_) return Error{ErrorCode::internal, "", "the server takes no more jobs: it is ending"};
    MOTE_RETURN_IF_ERROR(checkJobRequest(request, roots_));
    if (const auto* maker = table_->maker(request.output())) {
        return Error{ErrorCode::alreadyExists, "output",
                     fmt::format("job {} makes it already", maker->status.id())};
    }
    if (table_->count(State::QUEUED) >= settings_.queued) {
        return Error{ErrorCode::resourceExhausted, "",
                     fmt::format("{} jobs wait already: submit again when one has ended", settings_.queued)};
    }
    JobRecord record;
    record.status.set_id(newId());
    *record.status.mutable_request() = request;
    record.status.set_state(State::QUEUED);
    record.status.set_phase("waiting");
    record.status.set_created_ms(nowMs());
    MOTE_ASSIGN_OR_RETURN(const auto added, table_->add(std::move(record)));
    changed(*added);
    scheduleSoon();
    return added->status;
}

Status JobQueue::cancel(std::string_view id) {
    auto* record = table_ ? table_->find(id) : nullptr;
    if (!record) return Error{ErrorCode::notFound, "id", fmt::format("there is no job \"{}\"", id)};
    if (record->status.state() == State::QUEUED) {
        finish(*record, State::CANCELLED);
        return success();
    }
    if (record->status.state() != State::RUNNING || record->cancelRequested) return success();
    record->cancelRequested = true;
    record->status.set_phase("cancelling");
    changed(*record);
    if (const auto active = active_.find(record->number); active != active_.end())
        active->second.run->cancel();
    return success();
}

std::vector<proto::JobStatus> JobQueue::list() const {
    return table_ ? table_->list(kMostListed) : std::vector<proto::JobStatus>();
}

Result<proto::JobStatus> JobQueue::find(std::string_view id) const {
    const auto* record = table_ ? table_->find(id) : nullptr;
    if (!record) return Error{ErrorCode::notFound, "id", fmt::format("there is no job \"{}\"", id)};
    return record->status;
}

// ---------------------------------------------------------------------------------------- running jobs

void JobQueue::scheduleSoon() {
    if (std::exchange(scheduling_, true)) return;
    asio::post(context_, whileAlive([this] { schedule(); }));
}

void JobQueue::schedule() {
    scheduling_ = false;
    if (!table_) return;
    table_->prune(settings_.kept);
    while (active_.size() < settings_.running) {
        auto* record = table_->nextQueued();
        if (!record) return;
        begin(*record);
    }
}

void JobQueue::begin(JobRecord& record) {
    ++record.attempts;
    record.handle.clear();
    record.status.set_state(State::RUNNING);
    record.status.set_started_ms(nowMs());
    record.status.set_progress(0);
    record.status.set_phase("starting");
    Active active{JobFiles(directoryOf(record)), nullptr};
    auto run = launch(record, active.files);
    if (!run.ok()) return finish(record, State::FAILED, run.error().toString());
    active.run = *std::move(run);
    record.handle = active.run->handle();
    changed(record);
    // Only now that its handle is stored may it begin: no job ever runs that a restarted server would not
    // find.
    active.run->go();
    watch(record.number, std::move(active));
}

Result<std::unique_ptr<Run>> JobQueue::launch(JobRecord& record, JobFiles& files) {
    const auto output = findOutput(record.status.request(), roots_);
    if (!output.ok()) return Error{output.error().code, "output", output.error().toString()};
    MOTE_RETURN_IF_ERROR(files.prepare(record.status.request()));
    RunOrder order;
    order.directory = files.directory();
    for (const auto& [name, folder] : roots_.entries()) {
        order.roots.push_back(name + "=" + folder.string());
        order.readable.push_back(folder);
    }
    order.writable = output.value().root;
    order.memory = settings_.memory;
    order.threads = settings_.threads;
    return runner_->start(order);
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
    const auto outcome = files.outcome();
    const auto output = findOutput(record.status.request(), roots_);
    const bool there = output.ok() && output.value().exists;
    const bool clean = outcome && !outcome->signalled;
    if (!clean && output.ok()) removeDrafts(output.value());
    if (there && !(clean && outcome->number != 0)) return finish(record, State::SUCCEEDED);
    if (record.cancelRequested) return finish(record, State::CANCELLED);
    if (!outcome) return interrupted(record, files);
    if (clean && outcome->number == 0) {
        return finish(record, State::FAILED, "mote-prep ended without an error, but its output is not there");
    }
    finish(record, State::FAILED, sentenceOf(*outcome, record.status));
}

/// It ended without a result: the machine or someone's kill took it, not a fault of its own. Once more, then
/// no more.
void JobQueue::interrupted(JobRecord& record, JobFiles& files) {
    if (record.attempts >= kMostAttempts) {
        return finish(
            record, State::FAILED,
            "was interrupted twice (its process was killed, or the machine went down): submit it again");
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
                                          : "failed: " + error);
    changed(record);
    JobFiles(directoryOf(record)).remove();  // the store keeps the log's end
    scheduleSoon();
}

// ---------------------------------------------------------------------------------------------- small

void JobQueue::changed(const JobRecord& record) {
    table_->save(record);
    asio::post(context_, whileAlive([this, status = record.status] {
                   if (listener_) listener_(status);
               }));
}

std::filesystem::path JobQueue::directoryOf(const JobRecord& record) const {
    return settings_.stateDirectory / "jobs" / record.status.id();
}

}  // namespace mote::server
