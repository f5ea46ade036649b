// SPDX-License-Identifier: GPL-3.0-or-later
//
// Jobs of a server, as its clients see them: the request that makes a film, what people know a job by, and
// how it stands. Pure functions.
#pragma once

#include <functional>
#include <string>

#include "client/shared/server_line.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::client {

/// `video`: "mp4", "webm" or "gif"; "": its pictures alone. The script is a valid one.
proto::JobRequest filmRequest(const proto::Script& script, const std::string& video);

/// The catalogue's name of what a request makes: its output without ".mote".
std::string datasetName(const proto::JobRequest& request);
/// What people know a job by: the dataset that it makes, or its title.
std::string jobName(const proto::JobRequest& request);

/// "queued", "running", "succeeded", "failed" or "cancelled"; "unknown" for what only another server knows.
const char* stateName(proto::JobStatus::State state);
bool isUnderWay(const proto::JobStatus& job);
bool hasEnded(const proto::JobStatus& job);
/// What failed or was cancelled: the server makes a new job of it.
bool mayBeTriedAgain(const proto::JobStatus& job);
/// A film that is there to be fetched.
bool isReadyFilm(const proto::JobStatus& job);

// What programs ask of a server's jobs, and wait for. Main thread.

/// Tells of each job that the server knows once, the latest first, page by page, until `take` wants no more.
/// Errors: why the line was lost; cancelled (interrupted).
Status eachJob(ServerLine& server, const std::function<bool(const proto::JobStatus&)>& take);

/// The status of one job. Errors: notFound; as eachJob.
Result<proto::JobStatus> findJob(ServerLine& server, const std::string& id);

/// Waits for the end of a job, which goes on where the waiting ends before. `show` is told how it stands, and
/// of each change. Errors: notFound; show's; as eachJob. How the job ended is none.
Result<proto::JobStatus> awaitJob(ServerLine& server, const std::string& id,
                                  const std::function<Status(const proto::JobStatus&)>& show);

/// How far a job is, as one line of stderr that is written over, if that is a terminal; it
/// goes with its object. One thread.
class JobPercentage {
  public:
    /// `what` stands before the number. Shows nothing if it is not wanted.
    JobPercentage(std::string what, bool wanted);
    ~JobPercentage();
    JobPercentage(const JobPercentage&) = delete;
    JobPercentage& operator=(const JobPercentage&) = delete;

    void show(const proto::JobStatus& job);

  private:
    const std::string what_;
    const bool visible_;
    bool shown_ = false;
};

}  // namespace mote::client
