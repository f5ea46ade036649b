// SPDX-License-Identifier: GPL-3.0-or-later
//
// The runner that hands jobs to Slurm. Each becomes a batch job named "mote-ID" on one node: a fixed script
// that starts mote-supervise with the words that it gets; the user's own words are in the request file only.
// It is submitted held, and released once its number is stored. How it goes is asked of squeue, and of sacct
// where that knows it no more.
#pragma once

#include <memory>
#include <string_view>

#include "protocol/scene/error.h"
#include "server/jobs/job_settings.h"
#include "server/jobs/runner.h"

namespace mote::server {

/// The programs of Slurm are those in PATH (checkRunner); STATE and the roots must lie where its nodes see
/// them. The context outlives the runner and its runs. Errors: permissionDenied, resourceExhausted, internal
/// (the script cannot be written).
Result<std::unique_ptr<Runner>> makeSlurmRunner(asio::io_context& context, const JobSettings& settings);

/// Whether a run of such a runner has this handle.
bool isSlurmHandle(std::string_view handle);

}  // namespace mote::server
