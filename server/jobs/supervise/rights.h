// SPDX-License-Identifier: GPL-3.0-or-later
//
// Rights: what a job may do, which may have to do with foreign files; all else is given up before it begins
// and never regained. Used by mote-supervise in the child that becomes the job's program.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "protocol/scene/error.h"

namespace mote::server {

struct Rights {
    std::vector<std::filesystem::path> readable;    ///< folders and files
    std::vector<std::filesystem::path> executable;  ///< folders and files, read as well
    std::vector<std::filesystem::path> writable;    ///< folders and files, read as well
    std::uint64_t memory = 0;                       ///< bytes; 0: three quarters of the machine's
    int niceness = 0;                               ///< steps below the present priority, at least 0
    bool unixSockets = false;                       ///< these may be opened
    bool launcher = false;                          ///< mpirun: any sockets, and other processes
};

/// No core files, less memory, no file larger than there is room for, a lower priority, no privileges.
/// Errors: internal.
Status limitResources(const Rights& rights);

/// Landlock: the file system but for these folders disappears; so do TCP, abstract sockets and the processes
/// of others, as far as the kernel can. Folders that do not exist are left out. Errors: unsupported (a kernel
/// without it), permissionDenied (a writable folder became a link), internal.
Status limitFiles(const Rights& rights);

/// The kernel's version of Landlock; less than 1: it has none.
long landlockVersion();

/// Seccomp: the calls that such a program needs, and no others. Called in the process that is limited, once
/// it has all other limits. Errors: unsupported.
Status limitCalls(const Rights& rights);

}  // namespace mote::server
