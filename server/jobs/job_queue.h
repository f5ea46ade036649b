// SPDX-License-Identifier: GPL-3.0-or-later
//
// JobQueue: the server's jobs, from a client's request to a published dataset or a film that is kept. Owned
// by the server; everything here is called, and calls back, on the one thread that runs the io_context.
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
#include "server/jobs/film_files.h"
#include "server/jobs/job_files.h"
#include "server/jobs/job_settings.h"
#include "server/jobs/job_store.h"
#include "server/jobs/runner.h"
#include "storage/files/file_descriptor.h"
#include "storage/roots.h"

namespace mote::server {

class JobQueue {
  public:
    using Listener = std::function<void(const proto::JobStatus&)>;
    using FilmListener = std::function<void(Result<FilmPiece>)>;

    /// Nothing is touched before start().
    JobQueue(asio::io_context& context, JobSettings settings);
    /// Waits for what is done on the disk.
    ~JobQueue();
    JobQueue(const JobQueue&) = delete;
    JobQueue& operator=(const JobQueue&) = delete;

    /// Opens the state directory, goes on with the jobs that run, queues interrupted ones again (once, films
    /// more often) and begins. Errors: invalidArgument (a root), permissionDenied (the state directory cannot
    /// be made, is another user's or open to others), alreadyExists (another server has it), internal (the
    /// disk). A broken database is no error: it is moved aside, said in the log.
    Status start();

    /// No job is started any more and nothing calls back; running jobs go on and the next server finds them.
    void stop();

    /// Checks and queues a request. Errors: invalidArgument and notFound with the field, alreadyExists (the
    /// output, or a live job that makes it), resourceExhausted (too many wait, a full disk), internal (the
    /// disk). A film's status, here and below, is without the script.
    Result<proto::JobStatus> submit(const proto::JobRequest& request);

    /// A waiting job is cancelled at once, a running one told to end (SIGTERM, 5 s later SIGKILL): its last
    /// change says so. Cancelling a finished job is success and does nothing, but for a film that is done:
    /// that goes. Errors: notFound.
    Status cancel(std::string_view id);

    /// At most 200: what runs, then what waits, then what has ended, the newest first of each.
    std::vector<proto::JobStatus> list() const;

    /// Errors: notFound.
    Result<proto::JobStatus> find(std::string_view id) const;

    /// Reads a piece of a film that is done; `done` hears of it later, unless the queue is destroyed first.
    /// Errors: notFound (no such job, or it is not done), invalidArgument (it makes no film), as readFilm.
    void fetchFilm(const proto::FetchFilm& request, FilmListener done);

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
    void goOn();
    void goOnWith(JobRecord& record);
    void removeStrayDirectories();

    void scheduleSoon();
    void schedule();
    std::size_t activeCount(bool film) const;
    void begin(JobRecord& record);
    Result<RunOrder> prepare(const JobRecord& record, JobFiles& files) const;
    void watch(std::int64_t number, Active active);
    void watchSoon();
    void look();

    void end(std::int64_t number);
    void conclude(JobRecord& record, JobFiles& files);
    void concludeFilm(JobRecord& record, JobFiles& files);
    void interrupted(JobRecord& record, JobFiles& files, const std::string& how);
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
    Result<JobRecord> finishedFilm(std::string_view id) const;
    void discard(const JobRecord& record);
    void removeSoon(const std::filesystem::path& folder);
    static std::int64_t nowMs();

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
    asio::thread_pool disk_{1};  // what takes longer than the others should wait; last: it ends first
};

}  // namespace mote::server
