// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "server/jobs/job_environment.h"
#include "server/jobs/job_settings.h"
#include "server/jobs/runner.h"
#include "server/log.h"

namespace mote::server {
namespace {

/// sacct is asked too, but not needed: without accounting it knows nothing anyway.
std::vector<std::string_view> programsOf(std::string_view runner, unsigned ranks) {
    std::vector<std::string_view> programs;
    if (runner == "slurm") programs = {"sbatch", "squeue", "scontrol", "scancel"};
    if (runner != "local" && ranks > 1) programs.emplace_back("mpirun");
    return programs;
}

bool isSlurmHandle(std::string_view handle) {
    return handle.starts_with("slurm ");
}

/// Whether an earlier server's runs of Slurm are to be found, and can be.
bool findsRunsOfSlurm(const std::vector<std::string>& handles) {
    if (std::ranges::none_of(handles, isSlurmHandle)) return false;
    const auto there = checkRunner("slurm", 1);
    if (!there.ok()) log::warn("jobs that run in Slurm are lost: {}", there.error().toString());
    return there.ok();
}

}  // namespace

Status checkRunner(std::string_view runner, unsigned ranks) {
    if (runner != "local" && runner != "mpi" && runner != "slurm") {
        return Error{ErrorCode::invalidArgument, "--runner",
                     fmt::format("\"{}\" is none of local, mpi and slurm", runner)};
    }
    for (const auto program : programsOf(runner, ranks)) {
        if (findProgram(std::string(program)).is_absolute()) continue;
        return Error{ErrorCode::notFound, "--runner",
                     fmt::format("\"{}\" needs {}, which is not in PATH", runner, program)};
    }
    return success();
}

Result<Runners> Runners::open(asio::io_context& context, const JobSettings& settings,
                              const std::vector<std::string>& handles,
                              const std::vector<std::string>& waiting) {
    MOTE_RETURN_IF_ERROR(checkRunner(settings.runner, settings.ranks));
    Runners runners;
    runners.local_ = makeLocalRunner(context, settings.supervisor);
    runners.useSlurm_ = settings.runner == "slurm";
    if (!runners.useSlurm_ && !findsRunsOfSlurm(handles)) return runners;
    MOTE_ASSIGN_OR_RETURN(runners.slurm_, makeSlurmRunner(context, settings));
    runners.slurm_->forget(waiting);
    return runners;
}

Result<std::unique_ptr<Run>> Runners::find(std::string_view handle) const {
    if (!isSlurmHandle(handle)) return local_->find(handle);
    if (!slurm_) return std::unique_ptr<Run>();
    return slurm_->find(handle);
}

RunEnd Runners::endOfLost(std::string_view handle) const {
    if (!isSlurmHandle(handle) || slurm_) return {};
    return {"ran in Slurm, of which the server finds nothing any more: look there whether it still runs",
            false};
}

}  // namespace mote::server
