// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_environment.h"

#include <unistd.h>

#include <cstdlib>
#include <sstream>

namespace mote::server {
namespace {

constexpr const char* kNames[] = {
    "PATH",
    "LD_LIBRARY_PATH",
    "HOME",
    "USER",
    "LOGNAME",
    "TMPDIR",
    "LANG",
    "LC_ALL",
    "LC_CTYPE",
    "TZ",
    "OMP_NUM_THREADS",
    "OMP_PROC_BIND",
    "OMP_PLACES",
    "HDF5_USE_FILE_LOCKING",
    "ASAN_OPTIONS",
    "LSAN_OPTIONS",
    "TSAN_OPTIONS",
    "UBSAN_OPTIONS",
};

}  // namespace

std::vector<std::string> jobEnvironment() {
    std::vector<std::string> variables;
    for (const char* name : kNames) {
        if (const char* value = std::getenv(name)) variables.push_back(std::string(name) + "=" + value);
    }
    return variables;
}

std::vector<char*> pointersTo(std::vector<std::string>& variables) {
    std::vector<char*> pointers;
    pointers.reserve(variables.size() + 1);
    for (auto& variable : variables) pointers.push_back(variable.data());
    pointers.push_back(nullptr);
    return pointers;
}

std::filesystem::path findProgram(const std::string& name) {
    const char* path = std::getenv("PATH");
    std::istringstream folders(path ? path : "/usr/bin:/bin");
    for (std::string folder; std::getline(folders, folder, ':');) {
        auto program = std::filesystem::path(folder) / name;
        if (program.is_absolute() && ::access(program.c_str(), X_OK) == 0) return program;
    }
    return name;
}

}  // namespace mote::server
