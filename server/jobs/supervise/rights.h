// SPDX-License-Identifier: GPL-3.0-or-later
//
// Rights: what a job may do, which may have to do with foreign files; all else is given up before it begins
// and never regained. Used by mote-supervise in the child that becomes the job's program.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "protocol/scene/error.h"

namespace mote::server {

struct Rights {
    std::vector<std::filesystem::path> readable;    ///< folders and files
    std::vector<std::filesystem::path> executable;  ///< folders and files, read as well
    std::vector<std::filesystem::path> writable;    ///< folders, read as well
    std::uint64_t memory = 0;                       ///< bytes of private memory; 0: no limit
    int niceness = 0;                               ///< steps below the present priority, at least 0
    bool unixSockets = false;                       ///< these may be opened
};

/// No core files, less memory, a lower priority, no new privileges. Errors: internal.
Status limitResources(const Rights& rights);

/// Landlock: the file system but for these folders disappears. Folders that do not exist are left out.
/// Errors: unsupported (a kernel without it), internal.
Status limitFiles(const Rights& rights);

/// Seccomp: no sockets (but Unix ones where they are allowed), no other processes' memory, no namespaces,
/// mounts, modules or io_uring. Errors: unsupported.
Status limitCalls(const Rights& rights);

}  // namespace mote::server
