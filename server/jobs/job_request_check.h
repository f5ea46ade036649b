// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a server asks of a job request before it queues it: bounded, named beneath its roots, with an output
// that is not there yet. What the numbers mean is mote-prep's to judge. Pure, but for the look at the roots'
// folders.
#pragma once

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "server/jobs/job_output.h"
#include "storage/roots.h"

namespace mote::server {

/// Where the output is to appear. Errors: invalidArgument, notFound (a root, an input), alreadyExists (the
/// output), permissionDenied; each with the path of its field, as in JSON.
Result<JobOutput> checkJobRequest(const proto::JobRequest& request, const storage::Roots& roots);

}  // namespace mote::server
