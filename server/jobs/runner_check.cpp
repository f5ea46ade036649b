// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/runner_check.h"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "server/jobs/find_program.h"

namespace mote::server {
namespace {

/// sacct is asked too, but not needed: without accounting it knows nothing anyway.
std::vector<std::string_view> programsOf(std::string_view runner, unsigned ranks) {
    std::vector<std::string_view> programs;
    if (runner == "slurm") programs = {"sbatch", "squeue", "scontrol", "scancel"};
    if (runner != "local" && ranks > 1) programs.emplace_back("mpirun");
    return programs;
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

}  // namespace mote::server
