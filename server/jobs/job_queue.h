// SPDX-License-Identifier: GPL-3.0-or-later
//
// JobQueue: the server's jobs, from a client's request to a published dataset. Owned by the server;
// everything here is called, and calls back, on the one thread that runs the io_context.
//
// A job outlives the server: its process has a session of its own and leaves progress, log and result in
// files beneath the state directory, where the next server finds them. Destroying the queue therefore stops
// no job.
#pragma once

#include <asio/io_context.hpp>
#include <asio/steady_timer.hpp>
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
#include "server/jobs/job_files.h"
#include "server/jobs/job_store.h"
#include "server/jobs/runner.h"
#include "storage/files/file_descriptor.h"
#include "storage/roots.h"

namespace mote::server {

/// Where a server keeps its jobs and what each may use.
struct JobSettings {
    std::filesystem::path stateDirectory;  ///< made (0700) where absent; holds jobs.sqlite and jobs/ID/
    std::filesystem::path prep;            ///< the program mote-prep
    std::filesystem::path supervisor;      ///< mote-supervise; empty: beside `prep`
    std::vector<std::string> roots;        ///< "NAME=DIR", as the server's --root
    std::size_t running = 1;               ///< jobs that may run at a time, at least 1
    std::size_t queued = 1000;             ///< jobs that may wait
    std::size_t kept = 1000;               ///< finished jobs that are remembered
    std::uint64_t memory = 0;              ///< bytes for each job; 0: no limit
    unsigned threads = 0;                  ///< of each job; 0: its own choice
};

class JobQueue {
  public:
    using Listener = std::function<void(const proto::JobStatus&)>;

    /// Nothing is touched before start().
    JobQueue(asio::io_context& context, JobSettings settings);
    ~JobQueue() { stop(); }
    JobQueue(const JobQueue&) = delete;
    JobQueue& operator=(const JobQueue&) = delete;

    /// Opens the state directory, goes on with the jobs that run, queues interrupted ones again (once) and
    /// begins. Errors: invalidArgument (a root), permissionDenied, alreadyExists (another server has this
    /// state directory), internal (the disk). A broken database is no error: it is moved aside, said in the
    /// log.
    Status start();

    /// No job is started any more and nothing calls back; running jobs go on and the next server finds them.
    void stop();

    /// Checks and queues a request. Errors: invalidArgument and notFound with the field, alreadyExists (the
    /// output, or a live job that makes it), resourceExhausted (too many wait), internal (the disk).
    Result<proto::JobStatus> submit(const proto::JobRequest& request);

    /// A waiting job is cancelled at once, a running one told to end (SIGTERM, 5 s later SIGKILL): its last
    /// change says so. Cancelling a finished job is success and does nothing. Errors: notFound.
    Status cancel(std::string_view id);

    /// Newest first, at most 200: all live ones, then the latest finished ones.
    std::vector<proto::JobStatus> list() const;

    /// Errors: notFound.
    Result<proto::JobStatus> find(std::string_view id) const;

    /// Called after every change of state and, at most five times a second for each job, of progress. Never
    /// from within submit() or cancel(). One listener.
    void onChange(Listener listener) { listener_ = std::move(listener); }

  private:
    /// A job that runs now.
    struct Active {
        JobFiles files;
        std::unique_ptr<Run> run;
    };

    Status openState();
    void goOn();
    void goOnWith(JobRecord& record);
    void removeStrayDirectories();

    void scheduleSoon();
    void schedule();
    void begin(JobRecord& record);
    Result<std::unique_ptr<Run>> launch(JobRecord& record, JobFiles& files);
    void watch(std::int64_t number, Active active);
    void watchSoon();
    void look();

    void end(std::int64_t number);
    void conclude(JobRecord& record, JobFiles& files);
    void interrupted(JobRecord& record, JobFiles& files);
    void finish(JobRecord& record, proto::JobStatus::State state, std::string error = {});

    /// What is called later: only while the queue lives.
    template <class Call>
    auto whileAlive(Call call) {
        return [alive = std::weak_ptr(alive_), call = std::move(call)](const auto&... values) mutable {
            if (!alive.expired()) call(values...);
        };
    }
    /// Stores the record and tells the listener, soon.
    void changed(const JobRecord& record);
    std::filesystem::path directoryOf(const JobRecord& record) const;

    asio::io_context& context_;
    JobSettings settings_;
    storage::Roots roots_;
    storage::FileDescriptor lock_;  // held: no other server has this state directory
    std::optional<JobTable> table_;
    std::unique_ptr<Runner> runner_;
    std::map<std::int64_t, Active> active_;  // by the job's number
    asio::steady_timer timer_;
    Listener listener_;
    bool scheduling_ = false;  // schedule() is posted
    bool looking_ = false;     // the timer runs
    std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);
};

}  // namespace mote::server
