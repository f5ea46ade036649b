// SPDX-License-Identifier: GPL-3.0-or-later
//
// JobQueue: the server's jobs, from a client's request to a published dataset. Owned by the server;
// everything here is called, and calls back, on the one thread that runs the io_context.
//
// A job outlives the server: its process has a session of its own and leaves progress, log and result in
// files beneath the state directory, where the next server finds them. Destroying the queue therefore stops
// no job.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "server/jobs/job_settings.h"

namespace asio {
class io_context;
}

namespace mote::server {

class JobQueue {
  public:
    using Listener = std::function<void(const proto::JobStatus&)>;

    /// Nothing is touched before start().
    JobQueue(asio::io_context& context, JobSettings settings);
    ~JobQueue();
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
    void onChange(Listener listener);

  private:
    class Impl;
    std::shared_ptr<Impl> impl_;  // handlers hold it weakly
};

}  // namespace mote::server
