// SPDX-License-Identifier: GPL-3.0-or-later
//
// JobRequest: a job request as a value, whatever the kind of the job: bounded, without contradictions, and
// with the files that it reads and makes by name. What its numbers mean is for the job itself to judge
// (mote-prep); what the names lead to, for whoever knows the roots. A value; pure functions.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote {

/// A file that a job reads.
struct JobInput {
    std::string field;  ///< that names it: "particles.inputs[0]"
    std::string name;
};

struct JobRequest {
    proto::JobRequest message;
    std::vector<JobInput> inputs;  ///< in the order of the fields
};

/// Errors: invalidArgument, resourceExhausted (the whole message is too large), with the path of the field as
/// in JSON. A kind of job that this program does not know has neither inputs nor anything to check.
Result<JobRequest> parseJobRequest(const proto::JobRequest& message);

/// What parseJobRequest() holds a mesh job to, for who has the job alone. Errors: places within the job.
Status checkMeshJob(const proto::MeshJob& job);

/// Whether what it makes is no file of a root but stays with the job, to be fetched.
bool staysWithJob(const proto::JobRequest& message);

/// Whether several processes may do it together, under MPI.
bool mayHaveRanks(const proto::JobRequest& message);

/// Whether what it makes may be further steps of a live dataset.
bool appendsSteps(const proto::JobRequest& message);

/// The files that a request names as inputs, of a request that nobody has checked.
std::vector<JobInput> jobInputs(const proto::JobRequest& message);

}  // namespace mote
