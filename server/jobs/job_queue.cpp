// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_queue.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <string.h>
#include <sys/file.h>
#include <sys/random.h>

#include <algorithm>
#include <asio/post.hpp>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

#include "protocol/scene/job_request.h"
#include "protocol/scene/system_error.h"
#include "server/jobs/job_request_check.h"
#include "server/jobs/own_files.h"
#include "server/jobs/request_digest.h"
#include "server/jobs/uploads.h"
#include "server/log.h"

namespace mote::server {
namespace {

using State = proto::JobStatus;

constexpr std::chrono::milliseconds kLockPatience(500), kLockPause(5);
constexpr std::size_t kMostListed = 200;

/// A server that was just killed keeps its lock until the kernel has taken it apart.
bool lockSoon(int file) {
    const auto end = std::chrono::steady_clock::now() + kLockPatience;
    while (flock(file, LOCK_EX | LOCK_NB) != 0) {
        if (std::chrono::steady_clock::now() >= end) return false;
        std::this_thread::sleep_for(kLockPause);
    }
    return true;
}

/// 16 hexadecimal digits that no earlier database has used.
std::string newId() {
    std::uint64_t bits = 0;
    MOTE_CHECK(getrandom(&bits, sizeof bits, 0) == static_cast<ssize_t>(sizeof bits));
    return fmt::format("{:016x}", bits);
}

/// Takes out what is with the job's files: statuses are stored and told at every change, and no place for a
/// script or a selection of hundreds of kilobytes.
void forgetBulk(proto::JobRequest& request) {
    constexpr std::size_t bulk = 4096;  // bytes
    if (request.has_film()) {
        auto& script = *request.mutable_film()->mutable_script();
        proto::Script kept;
        if (script.has_fps()) kept.set_fps(script.fps());
        script = kept;
    }
    const std::size_t bytes = request.export_().select().ByteSizeLong();
    if (bytes <= bulk) return;
    // Absent it would read as all particles; a name that no view has is told, and refused where it is sent.
    auto& select = *request.mutable_export_()->mutable_select();
    select.Clear();
    select.set_named(fmt::format("a selection of {} bytes, which is with the job's files", bytes));
}

/// Of a film or an export that cannot be fetched.
std::string whyNot(const proto::JobStatus& status) {
    switch (status.state()) {
        case State::QUEUED:
            return "it waits to be made";
        case State::FAILED:
            return "it failed: " + status.error();
        case State::CANCELLED:
            return "it was cancelled";
        default:
            return fmt::format("{:.0f}% of it are made", std::floor(100.0 * status.progress()));
    }
}

}  // namespace

JobQueue::JobQueue(asio::io_context& context, JobSettings settings)
    : context_(context), settings_(std::move(settings)), timer_(context), holdTimer_(context) {}

JobQueue::~JobQueue() {
    stop();
    disk_.join();
}

// ------------------------------------------------------------------------------------------ begin and end

Status JobQueue::start() {
    MOTE_CHECK(!table_);
    MOTE_ASSIGN_OR_RETURN(roots_, storage::Roots::parse(settings_.roots));
    if (settings_.supervisor.empty()) settings_.supervisor = settings_.prep.parent_path() / "mote-supervise";
    if (settings_.frames.empty()) settings_.frames = settings_.prep.parent_path() / "mote-frames";
    settings_.running = std::max<std::size_t>(settings_.running, 1);
    MOTE_RETURN_IF_ERROR(openState());
    MOTE_RETURN_IF_ERROR(openUploads());
    MOTE_RETURN_IF_ERROR(openRunners());
    rememberRoots();
    goOn();
    removeStrayDrafts();
    scheduleSoon();
    return success();
}

/// A root of the user's own of that name goes first: then there are no uploads.
Status JobQueue::openUploads() {
    const auto same = [](const storage::Roots::Entry& root) { return root.name == Uploads::root; };
    if (std::ranges::any_of(roots_.entries(), same)) return success();
    MOTE_ASSIGN_OR_RETURN(uploads_, Uploads::makeFolder(settings_.stateDirectory));
    if (knowsAll_) removeStrayUploads();
    settings_.roots.push_back(fmt::format("{}={}", Uploads::root, uploads_.string()));
    MOTE_ASSIGN_OR_RETURN(roots_, storage::Roots::parse(settings_.roots));
    return success();
}

bool JobQueue::readsUploads(const proto::JobRequest& request) const {
    const auto inputs = jobInputs(request);
    return !uploads_.empty() && std::ranges::any_of(inputs, [](const auto& input) {
        return input.name.starts_with(std::string(Uploads::root) + "/");
    });
}

Status JobQueue::openState() {
    std::error_code code;
    auto& state = settings_.stateDirectory;
    std::filesystem::create_directories(state.parent_path(), code);
    // The user may have put a link in its place; in the directory itself there is none.
    if (auto place = std::filesystem::canonical(state, code); !code) state = std::move(place);
    // The ids in the database are names of folders that are removed: all of it must be ours.
    for (const auto& folder : {state, state / "jobs", filmConnectionFile(state).parent_path()})
        MOTE_RETURN_IF_ERROR(makeOwnFolder(folder));
    for (const char* file : {"jobs.lock", "jobs.sqlite", "jobs.sqlite-wal", "jobs.sqlite-shm",
                             "jobs.copy.sqlite", "jobs.copy.sqlite-wal", "jobs.copy.sqlite-shm"})
        MOTE_RETURN_IF_ERROR(checkOwnFile(state / file));
    state = std::filesystem::canonical(state, code);
    if (code) return Error{ErrorCode::permissionDenied, settings_.stateDirectory.string(), code.message()};
    lock_ = storage::FileDescriptor(
        open((state / "jobs.lock").c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0600));
    if (!lock_.valid()) {
        return Error{ErrorCode::permissionDenied, (state / "jobs.lock").string(), systemMessage(errno)};
    }
    if (!lockSoon(lock_.get())) {
        return Error{ErrorCode::alreadyExists, state.string(), "another server uses this state directory"};
    }
    // SQLite would take the umask's mode, and give its other files that of this one.
    for (const auto& file : {state / "jobs.sqlite", JobStore::copyOf(state / "jobs.sqlite")})
        storage::FileDescriptor(open(file.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0600));
    MOTE_ASSIGN_OR_RETURN(auto store, JobStore::open(state / "jobs.sqlite"));
    knowsAll_ = store.setAside().empty();
    JobTable table(std::move(store));
    MOTE_RETURN_IF_ERROR(table.load());
    table_.emplace(std::move(table));
    if (knowsAll_)
        removeStrayDirectories();  // after a broken database they may still belong to something that runs
    return success();
}

void JobQueue::stop() {
    active_.clear();
    unsure_.clear();
    again_.clear();
    timer_.cancel();
    holdTimer_.cancel();
    listener_ = nullptr;
    disk_.stop();
    table_.reset();
    lock_ = {};
}

void JobQueue::removeStrayDirectories() {
    std::error_code code;
    std::vector<std::filesystem::path> strays;
    std::filesystem::directory_iterator entry(settings_.stateDirectory / "jobs", code);
    for (; !code && entry != std::filesystem::directory_iterator(); entry.increment(code)) {
        const auto* record = table_->find(entry->path().filename().string());
        if (record && (isLive(*record) || hasFiles(*record))) continue;
        // Of a film that is not there the request stays, which may be tried again.
        strays.push_back(record && keepsFiles(*record) ? artifactFolder(entry->path()) : entry->path());
    }
    for (const auto& stray : strays) removeSoon(stray);
}

/// Takes up what an earlier server left.
void JobQueue::goOn() {
    for (auto* record : table_->all()) {
        if (record->status.state() == State::RUNNING) {
            goOnWith(*record);
        } else if (record->cancelRequested && (isLive(*record) || hasFiles(*record))) {
            finish(*record, State::CANCELLED);  // the earlier server had said so, and came no further
        }
    }
}

void JobQueue::goOnWith(JobRecord& record) {
    record.status.clear_waits_for();
    auto run = findRun(record.handle);
    if (!run.ok()) return lookWhenPossible(record, {}, run.error());
    Active active{JobFiles(directoryOf(record)), *std::move(run), isFilm(record)};
    active.files.refresh(record.status);
    if (!active.run) return conclude(record, active.files, endOfLost(record.handle));
    log::info(log::job(record.status.id()), "still runs");
    if (record.cancelRequested) active.run->cancel();
    watch(record.number, std::move(active));
}

// ------------------------------------------------------------------------------------------- requests

/// Nobody fills the queue alone.
Status JobQueue::checkRoom(const std::string& client) const {
    const auto full = [](std::size_t places, const char* whose) {
        return Error{ErrorCode::resourceExhausted, "",
                     fmt::format("{} jobs{} wait already: submit again when one has ended", places, whose)};
    };
    if (table_->count(State::QUEUED) >= settings_.queued) return full(settings_.queued, "");
    const auto share = std::max<std::size_t>(settings_.queued / 2, 1);
    if (!client.empty() && table_->waiting(client) >= share) return full(share, " of this client");
    return success();
}

Result<proto::JobStatus> JobQueue::submit(const proto::JobRequest& request, const JobWish& wish) {
    if (!table_) return Error{ErrorCode::internal, "", "the server takes no more jobs: it is ending"};
    const auto valid = parseJobRequest(request);
    const auto* uploads = uploads_.empty() ? "" : Uploads::root;
    const auto digest = valid.ok() ? requestDigest(request, roots_, uploads) : std::string();
    if (const auto* same = wish.again ? nullptr : sameJob(digest)) return same->status;
    MOTE_RETURN_IF_ERROR(checkJobRequest(request, roots_));
    const auto* maker = staysWithJob(request) ? nullptr : table_->maker(request.output());
    if (maker) {
        return Error{ErrorCode::alreadyExists, "output",
                     fmt::format("job {} makes it already", maker->status.id())};
    }
    MOTE_RETURN_IF_ERROR(checkRoom(wish.client));
    JobRecord record;
    record.status.set_id(newId());
    MOTE_ASSIGN_OR_RETURN(*record.status.mutable_request(),
                          uploads_.empty() ? Result<proto::JobRequest>(request)
                                           : Uploads::adopt(request, uploads_, record.status.id()));
    if (staysWithJob(request)) {
        MOTE_RETURN_IF_ERROR(JobFiles(directoryOf(record)).keepRequest(request));
        forgetBulk(*record.status.mutable_request());
    }
    record.status.set_state(State::QUEUED);
    record.status.set_phase("waiting");
    record.status.set_created_ms(nowMs());
    record.status.set_time_limit_s(timeLimitOf(wish));
    record.digest = digest;
    record.client = wish.client;
    const auto id = record.status.id();
    const auto directory = directoryOf(record);
    const auto added = table_->add(std::move(record));
    if (!added.ok()) {
        JobFiles(directory).remove();
        if (!uploads_.empty()) removeSoon(uploads_ / id);
        return added.error();
    }
    tell(**added);
    scheduleSoon();
    return (*added)->status;
}

Status JobQueue::cancel(std::string_view id) {
    auto* record = table_ ? table_->find(id) : nullptr;
    if (!record) return Error{ErrorCode::notFound, "id", fmt::format("there is no job \"{}\"", id)};
    const bool waits = record->status.state() == State::QUEUED || hasFiles(*record);
    if (!waits && (record->status.state() != State::RUNNING || record->cancelRequested)) return success();
    // Nobody is told of a cancel that the next server would not know of.
    const JobRecord before = *record;
    record->cancelRequested = true;
    if (const auto kept = table_->save(*record); !kept.ok()) {
        *record = before;
        hold(kept.error());
        return kept;
    }
    if (waits) {
        finish(*record, State::CANCELLED);
        return success();
    }
    record->status.set_phase("cancelling");
    tell(*record);
    if (const auto active = active_.find(record->number); active != active_.end())
        active->second.run->cancel();
    return success();
}

std::vector<proto::JobStatus> JobQueue::list() const {
    return table_ ? table_->list(kMostListed) : std::vector<proto::JobStatus>();
}

std::map<std::string, std::size_t> JobQueue::counts() const {
    std::map<std::string, std::size_t> counts;
    for (const auto state :
         {State::QUEUED, State::RUNNING, State::SUCCEEDED, State::FAILED, State::CANCELLED}) {
        std::string name = proto::JobStatus::State_Name(state);
        for (char& letter : name) letter = static_cast<char>(letter - 'A' + 'a');
        counts[name] = table_ ? table_->count(state) : 0;
    }
    return counts;
}

Result<proto::JobStatus> JobQueue::find(std::string_view id) const {
    const auto* record = table_ ? table_->find(id) : nullptr;
    if (!record) return Error{ErrorCode::notFound, "id", fmt::format("there is no job \"{}\"", id)};
    return record->status;
}

// ---------------------------------------------------------------------------------------------- films

Result<JobRecord> JobQueue::finishedMaker(std::string_view id) const {
    const auto* record = table_ ? table_->find(id) : nullptr;
    if (!record) return Error{ErrorCode::notFound, "id", fmt::format("there is no job \"{}\"", id)};
    if (!keepsFiles(*record))
        return Error{ErrorCode::invalidArgument, "id", fmt::format("job {} makes no film and no export", id)};
    if (hasFiles(*record)) return *record;
    return Error{ErrorCode::notFound, "id",
                 fmt::format("the {} of job {} is not there: {}", isFilm(*record) ? "film" : "export", id,
                             whyNot(record->status))};
}

void JobQueue::fetchArtifact(const proto::FetchFilm& request, ArtifactListener done) {
    auto record = finishedMaker(request.id());
    auto answer = [alive = std::weak_ptr(alive_), done = std::move(done)](Result<ArtifactPiece> piece) {
        if (!alive.expired()) done(std::move(piece));
    };
    if (!record.ok()) return asio::post(context_, [answer, error = record.error()] { answer(error); });
    asio::post(
        disk_, [this, answer, request, directory = directoryOf(*record), job = record->status.request()] {
            auto piece = readArtifact(directory, job, request);
            asio::post(context_, [answer, piece = std::move(piece)]() mutable { answer(std::move(piece)); });
        });
}

// ---------------------------------------------------------------------------------------------- small

std::int64_t JobQueue::nowMs() {
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    return std::chrono::duration_cast<std::chrono::milliseconds>(now).count();
}

void JobQueue::tell(const JobRecord& record) {
    asio::post(context_, whileAlive([this, status = record.status] {
                   if (listener_) listener_(status);
               }));
}

/// A film may be thousands of files: nobody waits until they are gone. So named the folder is no job's,
/// and should this server end first, the next one removes the rest.
void JobQueue::discard(const JobRecord& record, const std::filesystem::path& folder) {
    const std::filesystem::path gone = directoryOf(record).string() + ".gone";
    std::error_code code;
    std::filesystem::rename(folder, gone, code);
    removeSoon(code ? folder : gone);
}

std::function<void(const std::filesystem::path&)> JobQueue::remover() {
    return whileAlive([this](const std::filesystem::path& folder) { removeSoon(folder); });
}

void JobQueue::removeSoon(const std::filesystem::path& folder) {
    onDisk([folder] {
        std::error_code code;
        std::filesystem::remove_all(folder, code);
    });
}

std::filesystem::path JobQueue::directoryOf(const JobRecord& record) const {
    return settings_.stateDirectory / "jobs" / record.status.id();
}

}  // namespace mote::server
