// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/runner_check.h"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "server/jobs/find_program.h"

namespace mote::server {
namespace {

/// sacct is asked too, but not needed: without accounting it knows nothing anyway.
std::vector<std::string> programsOf(const JobSettings& settings) {
    std::vector<std::string> programs;
    if (settings.runner == "slurm") programs = {"sbatch", "squeue", "scontrol", "scancel"};
    if (settings.runner != "local" && settings.ranks > 1) programs.emplace_back("mpirun");
    return programs;
}

}  // namespace

Status checkRunner(const JobSettings& settings) {
    const auto& runner = settings.runner;
    if (runner != "local" && runner != "mpi" && runner != "slurm") {
        return Error{ErrorCode::invalidArgument, "--runner",
                     fmt::format("\"{}\" is none of local, mpi and slurm", runner)};
    }
    for (const auto& program : programsOf(settings)) {
        if (findProgram(program).is_absolute()) continue;
        return Error{ErrorCode::notFound, "--runner",
                     fmt::format("\"{}\" needs {}, which is not in PATH", runner, program)};
    }
    return success();
}

}  // namespace mote::server
