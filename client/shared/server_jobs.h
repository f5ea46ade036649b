// SPDX-License-Identifier: GPL-3.0-or-later
//
// What programs ask of a server's jobs, and wait for. Main thread.
#pragma once

#include <functional>
#include <string>

#include "client/shared/server_line.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"

namespace mote::client {

/// Tells of each job that the server knows once, the latest first, page by page, until `take` wants no more.
/// Errors: why the line was lost; cancelled (interrupted).
Status eachJob(ServerLine& server, const std::function<bool(const proto::JobStatus&)>& take);

/// The status of one job. Errors: notFound; as eachJob.
Result<proto::JobStatus> findJob(ServerLine& server, const std::string& id);

/// Waits for the end of a job, which goes on where the waiting ends before. `show` is told how it stands, and
/// of each change. Errors: notFound; show's; as eachJob. How the job ended is none.
Result<proto::JobStatus> awaitJob(ServerLine& server, const std::string& id,
                                  const std::function<Status(const proto::JobStatus&)>& show);

}  // namespace mote::client
