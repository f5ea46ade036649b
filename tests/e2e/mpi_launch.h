// SPDX-License-Identifier: GPL-3.0-or-later
//
// What mpirun needs to be told in tests, and what it started. Functions without state.
#pragma once

#include <fstream>

#include "tests/e2e/process.h"

namespace mote::test {

/// mpirun refuses root, and more ranks than cores, unless told: tests run in both. `folder` takes its
/// temporary files.
inline ProcessOptions mpiEnvironment(const std::filesystem::path& folder) {
    ProcessOptions options;
    options.environment = {{"OMPI_ALLOW_RUN_AS_ROOT", "1"},
                           {"OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"},
                           {"OMPI_MCA_rmaps_base_oversubscribe", "1"},
                           {"OMPI_MCA_btl_vader_single_copy_mechanism", "none"},
                           {"TMPDIR", folder.string()}};
    return options;
}

/// The processes that a process has started.
inline std::vector<pid_t> childrenOf(pid_t process) {
    std::vector<pid_t> children;
    std::error_code ignored;
    for (const auto& thread :
         std::filesystem::directory_iterator("/proc/" + std::to_string(process) + "/task", ignored)) {
        std::ifstream file(thread.path() / "children");
        for (pid_t child = 0; file >> child;) children.push_back(child);
    }
    return children;
}

}  // namespace mote::test
