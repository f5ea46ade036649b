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
#include <asio/thread_pool.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "server/jobs/artifact_files.h"
#include "server/jobs/job_files.h"
#include "server/jobs/job_settings.h"
#include "server/jobs/job_table.h"
#include "server/jobs/runner.h"
#include "storage/files/file_descriptor.h"
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

    /// Submits what failed or was cancelled anew, as another job. Errors: notFound, invalidArgument (it has
    /// not ended, or succeeded), as submit.
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

    /// The folder of clients' uploads; empty where there are none.
    const std::filesystem::path& uploads() const { return uploads_; }
    /// Removes a folder of the state directory that nobody uses any more, on a thread of the queue's; called
    /// on the queue's own, and after its end does nothing. What it does not come to, the next start removes.
    std::function<void(const std::filesystem::path& folder)> remover();

    /// Called after every change of state and, at most five times a second for each job, of progress. Never
    /// from within submit() or cancel(). One listener.
    void onChange(Listener listener) { listener_ = std::move(listener); }

  private:
    /// A job that runs now.
    struct Active {
        JobFiles files;
        std::unique_ptr<Run> run;
        bool film = false;
    };

    Status openState();
    Status openUploads();
    void removeStrayUploads();
    bool readsUploads(const proto::JobRequest& request) const;
    Status openRunners();
    bool findsRunsOfSlurm();
    Status openSlurm();
    void goOn();
    void goOnWith(JobRecord& record);
    void removeStrayDirectories();
    void removeStrayDrafts();

    Status checkRoom(const std::string& client) const;
    std::uint32_t timeLimitOf(const JobWish& wish) const;
    const JobRecord* sameJob(const std::string& digest) const;
    std::string madeBy(const JobRecord& record) const;
    bool isStillThere(const JobRecord& record) const;
    Runner& runnerOf(const JobRecord& record) const;
    Result<std::unique_ptr<Run>> findRun(std::string_view handle) const;
    RunEnd endOfLost(std::string_view handle) const;

    void scheduleSoon();
    void schedule();
    std::size_t activeCount(bool film) const;
    void begin(JobRecord& record);
    void begun(std::int64_t number, Result<std::unique_ptr<Run>> run);
    void cannotBegin(JobRecord& record, const Error& error);
    Result<std::filesystem::path> placeOf(const JobRecord& record) const;
    Result<RunOrder> prepare(const JobRecord& record, JobFiles& files,
                             const std::filesystem::path& output) const;
    void watch(std::int64_t number, Active active);
    void watchSoon();
    void look();

    void end(std::int64_t number, const RunEnd& how);
    void conclude(JobRecord& record, JobFiles& files, const RunEnd& end);
    void concludeArtifact(JobRecord& record, JobFiles& files, const std::optional<JobFiles::Outcome>& outcome,
                          const RunEnd& end);
    void lost(JobRecord& record, JobFiles& files, const RunEnd& end);
    void interrupted(JobRecord& record, JobFiles& files, const std::string& how);
    void finish(JobRecord& record, proto::JobStatus::State state, std::string error = {});

    /// What is called later: only while the queue lives.
    template <class Call>
    auto whileAlive(Call call) {
        return [this, alive = std::weak_ptr(alive_), call = std::move(call)](const auto&... values) mutable {
            if (!alive.expired()) call(values...);
        };
    }
    // What the place, and no job, is to blame for (job_hold.cpp).
    void rememberRoots();
    void lookForRoots();
    const Error* missingRoot(const JobRecord& record) const;
    void hold(const Error& why);
    void lookAgainLater();
    void goOnAfterHold();
    void waitAlone(JobRecord& record, const Error& why);
    void waitForPlace(JobRecord& record, const Error& why);
    void tryLater(JobRecord& record, JobFiles& files, const std::string& why);
    void lookWhenPossible(JobRecord& record, std::optional<RunEnd> end, const Error& why);
    void lookAtUnsure();
    void tellWhyItWaits(JobRecord& record, const Error& why);

    /// Stores the record and then tells the listener, soon. Errors: as JobTable::save; the queue is held
    /// then, and the listener hears of it when it is stored.
    Status changed(const JobRecord& record);
    /// Tells the listener, soon.
    void tell(const JobRecord& record);
    /// Its end is stored: nothing of it is needed any more, but for a film.
    void clearAway(const JobRecord& record);
    std::filesystem::path directoryOf(const JobRecord& record) const;
    Result<JobRecord> finishedMaker(std::string_view id) const;
    void discard(const JobRecord& record, const std::filesystem::path& folder);
    void removeSoon(const std::filesystem::path& folder);
    /// Does it on a thread that may take long.
    void onDisk(std::function<void()> work);
    void discardDraft(const std::filesystem::path& output, const std::string& job);
    static std::int64_t nowMs();

    asio::io_context& context_;
    JobSettings settings_;
    storage::Roots roots_;
    std::filesystem::path uploads_;  // empty: there are none
    storage::FileDescriptor lock_;   // held: no other server has this state directory
    std::optional<JobTable> table_;
    std::unique_ptr<Runner> local_, slurm_;  // slurm_: null where there is no such runner
    std::map<std::int64_t, Active> active_;  // by the job's number
    std::map<std::int64_t, bool> starting_;  // with their runner; by the job's number, whether it is a film
    /// A job of which it cannot be seen now whether it runs, or what came of it.
    struct Unsure {
        bool film = false;
        std::optional<RunEnd> end;  ///< it has ended, like this
    };
    std::map<std::int64_t, Unsure> unsure_;  // by number
    /// A job whose run found the place at fault.
    struct Again {
        int tries = 0;
        asio::steady_timer timer;
        bool waits = false;  ///< for the timer
    };
    std::map<std::int64_t, Again> again_;  // by number
    asio::steady_timer timer_;
    Listener listener_;
    /// A root's folder, and the file system that it lay in when the server began.
    struct RootPlace {
        std::string name;
        std::filesystem::path folder;
        std::uint64_t device = 0;
    };
    std::vector<RootPlace> rootPlaces_;
    asio::steady_timer holdTimer_;
    std::chrono::milliseconds holdFor_{0};  // how long the next hold is
    std::map<std::string, Error> away_;     // roots, by name, when they were last looked for
    bool knowsAll_ = true;                  // jobs in the state directory, but for a broken database
    bool held_ = false;                     // nothing begins
    bool waiting_ = false;                  // the hold's timer runs
    bool scheduling_ = false;               // schedule() is posted
    bool looking_ = false;                  // the timer runs
    std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);
    asio::thread_pool disk_{1};  // what takes longer than the others should wait; last: it ends first
};

}  // namespace mote::server
