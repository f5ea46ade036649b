// SPDX-License-Identifier: GPL-3.0-or-later
//
// JobQueue: the server's jobs, from a client's request to a published dataset or a film or export that is
// kept. Owned by the server; everything here is called, and calls back, on the one thread that runs the
// io_context.
//
// A job outlives the server: its process has a session of its own and leaves progress, log and result in
// files beneath the state directory, where the next server finds them. Destroying the queue therefore stops
// no job.
#pragma once

#include <asio/io_context.hpp>
#include <asio/steady_timer.hpp>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "server/jobs/disk_work.h"
#include "server/jobs/job_files.h"
#include "server/jobs/job_inputs.h"
#include "server/jobs/job_life.h"
#include "server/jobs/job_settings.h"
#include "server/jobs/job_table.h"
#include "server/jobs/runner.h"
#include "server/jobs/state_directory.h"
#include "storage/roots.h"

namespace mote::server {

/// How a request is to be run.
struct JobWish {
    bool again = false;           ///< although the same request waits, runs or has its output there
    std::uint32_t timeLimit = 0;  ///< s, of a run; 0: the server's, which is never exceeded
    std::string client = {};      ///< who takes turns with others, and half of the queue's places at most
};

class JobQueue {
  public:
    using Listener = std::function<void(const proto::JobStatus&)>;
    using ArtifactListener = std::function<void(Result<ArtifactPiece>)>;

    /// Nothing is touched before start().
    JobQueue(asio::io_context& context, JobSettings settings);
    /// Waits for what is done on the disk.
    ~JobQueue();
    JobQueue(const JobQueue&) = delete;
    JobQueue& operator=(const JobQueue&) = delete;

    /// Opens the state directory, goes on with the jobs that run, queues interrupted ones again (once, films
    /// more often) and begins. Errors: as checkRunner, invalidArgument (a root), permissionDenied (the state
    /// directory cannot be made, is another user's or open to others), alreadyExists (another server has it),
    /// internal (the disk). A broken database is no error: it is moved aside, said in the log.
    Status start();

    /// No job is started any more and nothing calls back; running jobs go on and the next server finds them.
    void stop();

    /// Checks and queues a request. The same one that waits, runs, or whose output is there and whose inputs
    /// are unchanged, is answered with that job. Errors: invalidArgument and notFound with the field,
    /// alreadyExists (the output, or a live job that makes it), resourceExhausted (too many wait, a full
    /// disk), internal (the disk). A film's status, here and below, is without the script; in an
    /// export's, `named` says how large a selection is that it has no place for.
    Result<proto::JobStatus> submit(const proto::JobRequest& request, const JobWish& wish = {});

    /// Submits what failed or was cancelled, or a film or an export, anew, as another job. Errors: notFound,
    /// invalidArgument (it has not ended, or made a dataset), as submit.
    Result<proto::JobStatus> retry(std::string_view id, const std::string& client = {});

    /// A waiting job is cancelled at once, a running one told to end (SIGTERM, 5 s later SIGKILL): its last
    /// change says so. Cancelling a finished job is success and does nothing, but for a film or export that
    /// is done: that goes. Errors: notFound.
    Status cancel(std::string_view id);

    /// At most 200: what runs, then what waits, then what has ended, the newest first of each.
    std::vector<proto::JobStatus> list() const;

    /// How many jobs are remembered, and a page of at most `count` (0: 200) of them, the latest first.
    proto::Jobs page(std::uint64_t first, std::uint32_t count) const;

    /// How many jobs are remembered.
    std::size_t size() const { return table_ ? table_->size() : 0; }

    /// Errors: notFound.
    Result<proto::JobStatus> find(std::string_view id) const;
    /// Of all that are remembered, by the state's name in lower case; none after stop().
    std::map<std::string, std::size_t> counts() const;

    /// Reads a piece of a film or export that is done; `done` hears of it later, unless the queue is
    /// destroyed first. Errors: notFound (no such job, or it is not done), invalidArgument (it makes
    /// neither), as readArtifact.
    void fetchArtifact(const proto::FetchFilm& request, ArtifactListener done);

    /// After start(): with all that was left out, the state directory by its real path, the root of uploads.
    const JobSettings& settings() const { return settings_; }
    /// The folder of clients' uploads; empty where there are none.
    const std::filesystem::path& uploads() const { return uploads_; }
    /// Removes a folder of the state directory that nobody uses any more, on a thread of the queue's; called
    /// on the queue's own, and after its end does nothing. What it does not come to, the next start removes.
    std::function<void(const std::filesystem::path& folder)> remover();

    /// Called after every change of state and, at most five times a second for each job, of progress. Never
    /// from within submit() or cancel(). One listener.
    void onChange(Listener listener) { listener_ = std::move(listener); }

  private:
    /// What is known of a job that waits or runs, beside its record.
    struct Live {
        JobLife::Stage stage;
        JobFiles files;
        int roomless = 0;
        std::unique_ptr<Run> run = nullptr;           ///< while its end is waited for
        RunEnd end = {};                              ///< of a run that is over
        std::optional<asio::steady_timer> rest = {};  ///< the end of its pause
    };

    Status openTable();
    Status openUploads();
    void goOn();
    void removeStrays();
    bool readsUploads(const proto::JobRequest& request) const;
    Status checkRoom(const std::string& client) const;
    std::uint32_t timeLimitOf(const JobWish& wish) const;
    const JobRecord* sameJob(const std::string& digest) const;
    bool isStillThere(const JobRecord& record) const;
    Result<JobRecord> finishedMaker(std::string_view id) const;

    // What happens to jobs (job_runs.cpp).
    JobLife lifeOf(const JobRecord& record) const;
    void happens(JobRecord& record, JobEvent event, const std::string& why = {});
    void perform(JobDeed deed, JobRecord& record, const std::string& why);
    void waitAgain(JobRecord& record, const JobLife& life, const std::string& why);
    void finish(JobRecord& record, const JobStep& last);
    void clearAway(const JobRecord& record);
    void discard(const JobRecord& record, const std::filesystem::path& folder);

    void scheduleSoon();
    void schedule();
    std::size_t placesTaken(bool film);
    bool waitsItsTurn(const JobRecord& record);
    void begin(JobRecord& record);
    Result<RunOrder> prepare(const JobRecord& record, JobFiles& files,
                             const std::filesystem::path& output) const;
    void cannotBegin(JobRecord& record, const Error& error);
    void begun(std::int64_t number, Result<std::unique_ptr<Run>> run);
    void watch(JobRecord& record);
    void lookSoon();
    void lookAtProgress();

    void seek(JobRecord& record);
    void conclude(JobRecord& record);
    struct Verdict {
        JobEvent event;
        std::string why = {};
    };
    using MaybeOutcome = std::optional<JobFiles::Outcome>;
    Verdict verdictOfDataset(const JobRecord& record, const MaybeOutcome& outcome, const RunEnd& end);
    Verdict verdictOfArtifact(const JobRecord& record, const MaybeOutcome& outcome, const RunEnd& end) const;
    static Verdict lostTo(const RunEnd& end);

    void hold(const std::string& why);
    void lookAgainLater();
    void goOnAfterHold();
    void tellWhyItWaits(JobRecord& record, const std::string& why);
    /// Stores the record and then tells the listener, soon. Errors: as JobTable::save; the queue is held
    /// then, and the listener hears of it when it is stored.
    Status changed(const JobRecord& record);
    /// Tells the listener, soon.
    void tell(const JobRecord& record);

    /// What is called later: only while the queue lives.
    template <class Call>
    auto whileAlive(Call call) {
        return [alive = std::weak_ptr(alive_), call = std::move(call)](auto&&... values) mutable {
            if (!alive.expired()) call(std::forward<decltype(values)>(values)...);
        };
    }
    std::filesystem::path directoryOf(const JobRecord& record) const {
        return settings_.stateDirectory / "jobs" / record.status.id();
    }

    asio::io_context& context_;
    JobSettings settings_;
    storage::Roots roots_;
    RootWatch rootWatch_;
    std::optional<StateDirectory> state_;
    std::filesystem::path uploads_;  // empty: there are none
    std::optional<JobTable> table_;
    std::optional<Runners> runners_;
    std::map<std::int64_t, Live> live_;  // by the job's number
    Listener listener_;
    asio::steady_timer progressTimer_, holdTimer_;
    std::chrono::milliseconds holdFor_{0};  // how long the next hold is
    bool knowsAll_ = true;                  // jobs in the state directory, but for a broken database
    bool held_ = false;                     // nothing begins
    bool waiting_ = false;                  // the hold's timer runs
    bool scheduling_ = false;               // schedule() is posted
    bool looking_ = false;                  // the timer for progress runs
    std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);
    DiskWork disk_;  // last: it ends first
};

}  // namespace mote::server
