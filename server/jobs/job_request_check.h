// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a server asks of a job request before it queues it: that it is one (protocol/scene/job_request.h), its
// inputs lie beneath the roots and its output is not there yet; the kind of job does not matter. Pure, but
// for the look at the roots' folders.
#pragma once

#include <filesystem>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "storage/roots.h"

namespace mote::server {

/// JobOutput: where the output of a job request lies beneath the roots. A value; looking it up touches no
/// file.
struct JobOutput {
    std::filesystem::path path;  ///< real, but for its last part
    std::filesystem::path root;  ///< the folder of its root
    bool exists = false;
};

/// Errors: invalidArgument, notFound (its root or its folder), permissionDenied.
Result<JobOutput> findOutput(const proto::JobRequest& request, const storage::Roots& roots);

/// Where the output is to appear; of a film or an export nowhere. Errors: invalidArgument, notFound (a root,
/// an input), alreadyExists (the output), permissionDenied; each with the path of its field, as in JSON.
Result<JobOutput> checkJobRequest(const proto::JobRequest& message, const storage::Roots& roots);

}  // namespace mote::server
