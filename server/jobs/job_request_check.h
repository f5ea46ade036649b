// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a server asks of a job request before it queues it: that it is one (protocol/scene/job_request.h), its
// inputs lie beneath the roots and its output is not there yet; the kind of job does not matter. Pure, but
// for the look at the roots' folders.
#pragma once

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "server/jobs/job_output.h"
#include "storage/roots.h"

namespace mote::server {

/// Where the output is to appear. Errors: invalidArgument, notFound (a root, an input), alreadyExists (the
/// output), permissionDenied; each with the path of its field, as in JSON.
Result<JobOutput> checkJobRequest(const proto::JobRequest& message, const storage::Roots& roots);

}  // namespace mote::server
