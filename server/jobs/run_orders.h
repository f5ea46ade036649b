// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is to run for a job, by its kind: mote-prep for what makes a dataset or an export, mote-frames for a
// film. Pure functions.
#pragma once

#include <filesystem>

#include "protocol/mote.pb.h"
#include "server/jobs/job_settings.h"
#include "server/jobs/runner.h"
#include "storage/roots.h"

namespace mote::server {

/// `directory`: of the job, holds request.json and where its output is to lie. It is made in a draft folder
/// beside that place, and mote-supervise puts it there. Several ranks run under mpirun, each with its part of
/// the memory.
RunOrder prepOrder(const JobSettings& settings, const storage::Roots& roots,
                   const std::filesystem::path& directory, unsigned ranks = 1);

/// How many processes the request's job has: as many as the settings say where its kind can have several.
unsigned ranksOf(const JobSettings& settings, const proto::JobRequest& request);

/// What it makes stays with the job.
RunOrder exportOrder(const JobSettings& settings, const storage::Roots& roots,
                     const std::filesystem::path& directory);

/// It reads no foreign files but is a client of this server, or of the next one.
RunOrder filmOrder(const JobSettings& settings, const std::filesystem::path& directory);

}  // namespace mote::server
