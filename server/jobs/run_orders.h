// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is to run for a job, by its kind: mote-prep for what makes a dataset, mote-frames for a film. Pure
// functions.
#pragma once

#include <filesystem>

#include "server/jobs/job_settings.h"
#include "server/jobs/runner.h"
#include "storage/roots.h"

namespace mote::server {

/// `directory`: of the job, holds request.json; `output`: the folder of the root that it writes to.
RunOrder prepOrder(const JobSettings& settings, const storage::Roots& roots,
                   const std::filesystem::path& directory, const std::filesystem::path& output);

/// It reads no foreign files but is a client of this server, or of the next one.
RunOrder filmOrder(const JobSettings& settings, const std::filesystem::path& directory);

}  // namespace mote::server
