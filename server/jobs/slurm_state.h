// SPDX-License-Identifier: GPL-3.0-or-later
//
// What Slurm prints of its jobs, as values. Pure functions; what makes no sense is left out.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "server/jobs/runner.h"

namespace mote::server {

/// A line of squeue.
struct SlurmState {
    std::string state;   ///< "PENDING", "RUNNING", ...
    std::string reason;  ///< why it waits: "JobHeldUser", ...
};

/// Of lines "NUMBER|STATE|REASON", by the job's number.
std::map<std::uint64_t, SlurmState> parseQueue(std::string_view lines);

/// Of lines "NUMBER|NAME": the numbers of each name.
std::multimap<std::string, std::uint64_t> parseNames(std::string_view lines);

/// What `sbatch --parsable` prints: "NUMBER" or "NUMBER;CLUSTER".
std::optional<std::uint64_t> parseNumber(std::string_view text);

/// Whether nothing of a job in this state runs, or will.
bool hasEnded(std::string_view state);

/// What is known of a job that ended in this state, as squeue or sacct says it ("CANCELLED by 1000").
RunEnd endOf(std::string_view state);

}  // namespace mote::server
