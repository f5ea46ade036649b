// SPDX-License-Identifier: GPL-3.0-or-later
//
// The queue's begin and end, and what clients ask of it.
#include "server/jobs/job_queue.h"

#include <fmt/format.h>
#include <sys/random.h>

#include <algorithm>
#include <asio/post.hpp>
#include <cmath>
#include <utility>

#include "protocol/base/json.h"
#include "protocol/scene/job_request.h"
#include "server/jobs/uploads.h"
#include "server/log.h"

namespace mote::server {
namespace {

using State = proto::JobStatus;

constexpr std::uint32_t kMostListed = 200;

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
        case State::SUCCEEDED:
            return "it was made, and thrown away since";
        default:
            return fmt::format("{:.0f}% of it are made", std::floor(100.0 * status.progress()));
    }
}

}  // namespace

JobQueue::JobQueue(asio::io_context& context, JobSettings settings)
    : context_(context), settings_(std::move(settings)), progressTimer_(context), holdTimer_(context) {}

JobQueue::~JobQueue() {
    stop();
}

// ------------------------------------------------------------------------------------------ begin and end

Status JobQueue::start() {
    MOTE_CHECK(!table_);
    MOTE_ASSIGN_OR_RETURN(roots_, storage::Roots::parse(settings_.roots));
    if (settings_.supervisor.empty()) settings_.supervisor = settings_.prep.parent_path() / "mote-supervise";
    if (settings_.frames.empty()) settings_.frames = settings_.prep.parent_path() / "mote-frames";
    settings_.running = std::max<std::size_t>(settings_.running, 1);
    MOTE_ASSIGN_OR_RETURN(auto state, StateDirectory::open(settings_.stateDirectory));
    settings_.stateDirectory = state.path();
    state_.emplace(std::move(state));
    MOTE_RETURN_IF_ERROR(openTable());
    MOTE_RETURN_IF_ERROR(openUploads());
    std::vector<std::string> handles, waiting;
    for (const auto* record : table_->all()) {
        handles.push_back(record->handle);
        if (record->status.state() == State::QUEUED) waiting.push_back(record->status.id());
    }
    MOTE_ASSIGN_OR_RETURN(auto runners, Runners::open(context_, settings_, handles, waiting));
    runners_.emplace(std::move(runners));
    rootWatch_ = RootWatch(roots_);
    removeStrays();
    goOn();
    scheduleSoon();
    return success();
}

Status JobQueue::openTable() {
    MOTE_ASSIGN_OR_RETURN(auto store, JobStore::open(state_->database()));
    knowsAll_ = store.setAside().empty();
    JobTable table(std::move(store));
    MOTE_RETURN_IF_ERROR(table.load());
    table_.emplace(std::move(table));
    return success();
}

/// A root of the user's own of that name goes first: then there are no uploads.
Status JobQueue::openUploads() {
    const auto same = [](const storage::Roots::Entry& root) { return root.name == Uploads::root; };
    if (std::ranges::any_of(roots_.entries(), same)) return success();
    MOTE_ASSIGN_OR_RETURN(uploads_, Uploads::makeFolder(settings_.stateDirectory));
    settings_.roots.push_back(fmt::format("{}={}", Uploads::root, uploads_.string()));
    MOTE_ASSIGN_OR_RETURN(roots_, storage::Roots::parse(settings_.roots));
    return success();
}

/// Takes up what an earlier server left.
void JobQueue::goOn() {
    for (auto* record : table_->all()) {
        const bool runs = record->status.state() == State::RUNNING;
        if (isLive(*record)) {
            const auto stage = runs ? JobLife::Stage::unsure : JobLife::Stage::waits;
            live_.emplace(record->number, Live{stage, JobFiles(directoryOf(*record))});
        }
        if (runs) {
            seek(*record);
        } else if (record->cancelRequested) {
            happens(*record, JobEvent::cancel);  // the earlier server had said so, and came no further
        }
    }
    std::vector<DraftOwner> owners;
    for (const auto* record : table_->all()) {
        if (!keepsFiles(*record))
            owners.push_back({record->status.request().output(), record->status.id(), isLive(*record)});
    }
    disk_.sweepDrafts(roots_, std::move(owners));
}

/// Folders that the earlier server did not come to remove. After a broken database they may still belong to
/// something that runs.
void JobQueue::removeStrays() {
    std::vector<std::filesystem::path> strays;
    std::error_code code;
    const auto eachIn = [&code](const std::filesystem::path& folder, const auto& look) {
        std::filesystem::directory_iterator entry(folder, code);
        for (; !code && entry != std::filesystem::directory_iterator(); entry.increment(code))
            look(entry->path());
    };
    const auto recordOf = [this](const std::filesystem::path& path) {
        return std::as_const(*table_).find(path.filename().string());
    };
    if (!knowsAll_) return;
    eachIn(state_->jobs(), [&](const auto& path) {
        const auto* record = recordOf(path);
        if (record && (isLive(*record) || hasFiles(*record))) return;
        // Of an artifact that is not there the request stays, which may be tried again.
        strays.push_back(record && keepsFiles(*record) ? artifactFolder(path) : path);
    });
    if (!uploads_.empty()) {
        eachIn(uploads_, [&](const auto& path) {
            const auto* record = recordOf(path);
            if (!record || !isLive(*record)) strays.push_back(path);
        });
    }
    for (const auto& stray : strays) disk_.remove(stray);
}

void JobQueue::stop() {
    live_.clear();
    progressTimer_.cancel();
    holdTimer_.cancel();
    listener_ = nullptr;
    disk_.stop();
    table_.reset();
    state_.reset();
}

// ------------------------------------------------------------------------------------------- requests

bool JobQueue::readsUploads(const proto::JobRequest& request) const {
    const auto inputs = jobInputs(request);
    return !uploads_.empty() && std::ranges::any_of(inputs, [](const auto& input) {
        return input.name.starts_with(std::string(Uploads::root) + "/");
    });
}

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
    const bool anew = wish.again || appendsSteps(request);
    if (const auto* same = anew ? nullptr : sameJob(digest)) return same->status;
    MOTE_RETURN_IF_ERROR(checkJobRequest(request, roots_));
    const auto* maker = staysWithJob(request) ? nullptr : table_->maker(request.output());
    if (maker && !(appendsSteps(request) && appendsSteps(maker->status.request()))) {
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
    record.status.set_created_ms(unixMs());
    record.status.set_time_limit_s(timeLimitOf(wish));
    record.digest = digest;
    record.client = wish.client;
    const auto id = record.status.id();
    const auto directory = directoryOf(record);
    const auto added = table_->add(std::move(record));
    if (!added.ok()) {
        JobFiles(directory).remove();
        if (!uploads_.empty()) disk_.remove(uploads_ / id);
        return added.error();
    }
    live_.emplace((*added)->number, Live{JobLife::Stage::waits, JobFiles(directory)});
    tell(**added);
    scheduleSoon();
    return (*added)->status;
}

/// The server's is never exceeded.
std::uint32_t JobQueue::timeLimitOf(const JobWish& wish) const {
    if (wish.timeLimit == 0 || settings_.timeLimit == 0) return std::max(wish.timeLimit, settings_.timeLimit);
    return std::min(wish.timeLimit, settings_.timeLimit);
}

bool JobQueue::isStillThere(const JobRecord& record) const {
    if (record.status.state() != State::SUCCEEDED) return false;
    if (keepsFiles(record)) return artifactIsThere(directoryOf(record), record.status.request());
    return !record.made.empty() && identityOfOutput(record.status.request(), roots_) == record.made;
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
    const bool nothingInItsWay = state == State::SUCCEEDED && keepsFiles(*record);
    if (state != State::FAILED && state != State::CANCELLED && !nothingInItsWay) {
        return Error{
            ErrorCode::invalidArgument, "id",
            fmt::format("job {} {}: only what failed or was cancelled is tried again, and films and exports",
                        id, state == State::SUCCEEDED ? "succeeded" : "has not ended")};
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
    const bool isThere = nothingInItsWay && hasFiles(*record);
    return submit(request, {isThere, record->status.time_limit_s(), client});
}

Status JobQueue::cancel(std::string_view id) {
    auto* record = table_ ? table_->find(id) : nullptr;
    if (!record) return notFound("id", fmt::format("there is no job \"{}\"", id));
    const bool runs = record->status.state() == State::RUNNING;
    if (runs ? record->cancelRequested : record->status.state() != State::QUEUED && !hasFiles(*record))
        return success();
    // Nobody is told of a cancel that the next server would not know of.
    JobRecord cancelled = *record;
    cancelled.cancelRequested = true;
    if (auto kept = table_->save(cancelled); !kept.ok()) {
        hold(kept.error().toString());
        return kept;
    }
    if (runs) record->status.set_phase("cancelling");
    if (runs) tell(*record);
    happens(*record, JobEvent::cancel);
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

proto::Jobs JobQueue::page(std::uint64_t first, std::uint32_t count) const {
    proto::Jobs page;
    if (!table_) return page;
    const auto most = count == 0 ? kMostListed : std::min(count, kMostListed);
    for (auto& status : table_->page(first, most)) *page.add_jobs() = std::move(status);
    page.set_total(table_->size());
    page.set_first(first);
    return page;
}

// ----------------------------------------------------------------------------------------- artifacts

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
    auto answer = whileAlive(std::move(done));
    if (!record.ok())
        return asio::post(context_, [answer, error = record.error()]() mutable { answer(error); });
    disk_.post([this, answer, request, directory = directoryOf(*record), job = record->status.request()] {
        auto piece = readArtifact(directory, job, request);
        asio::post(context_, [answer, piece = std::move(piece)]() mutable { answer(std::move(piece)); });
    });
}

std::function<void(const std::filesystem::path&)> JobQueue::remover() {
    return whileAlive([this](const std::filesystem::path& folder) { disk_.remove(folder); });
}

}  // namespace mote::server
