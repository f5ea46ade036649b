// SPDX-License-Identifier: GPL-3.0-or-later
//
// The environment of a job: named variables, and nothing else of what the server was started with. A function
// without state; while it runs no other thread changes the environment.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace mote::server {

/// "NAME=VALUE" of those variables of this process that a job may have: where programs and libraries lie,
/// language and time zone, threads, and how HDF5 locks files. No launcher's of MPI are among them: a job is
/// none of the server's ranks, and would wait for the others.
std::vector<std::string> jobEnvironment();

/// As execve() and posix_spawn() want it; `variables` outlive it.
std::vector<char*> pointersTo(std::vector<std::string>& variables);

/// Where PATH has a program of the system; the name alone where it is nowhere.
std::filesystem::path findProgram(const std::string& name);

}  // namespace mote::server
