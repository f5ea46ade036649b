// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/find_program.h"

#include <unistd.h>

#include <cstdlib>
#include <sstream>

namespace mote::server {

std::filesystem::path findProgram(const std::string& name) {
    const char* path = std::getenv("PATH");
    std::istringstream folders(path ? path : "/usr/bin:/bin");
    for (std::string folder; std::getline(folders, folder, ':');) {
        const auto program = std::filesystem::path(folder) / name;
        if (program.is_absolute() && ::access(program.c_str(), X_OK) == 0) return program;
    }
    return name;
}

}  // namespace mote::server
