// SPDX-License-Identifier: GPL-3.0-or-later
//
// One job from its request, whatever its kind: names become paths, the job runs, and what it made is told.
// Called from main; one thread.
#pragma once

#include <filesystem>

#include "preprocess/job_resources.h"
#include "preprocess/progress.h"
#include "protocol/mote.pb.h"
#include "storage/roots.h"

namespace mote::prep {

struct JobOutcome {
    std::filesystem::path output;  ///< the dataset or file
    proto::Manifest manifest;      ///< of a dataset; without a kind of anything else
};

/// With roots, inputs and output are "ROOT/PATH" beneath them; without, paths. Errors: invalidArgument with
/// the field's path, and the job's own.
Result<JobOutcome> runJob(const proto::JobRequest& request, const storage::Roots& roots,
                          const JobResources& resources, Progress& progress);

}  // namespace mote::prep
