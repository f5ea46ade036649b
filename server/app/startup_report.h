// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a server found when it began, said in its log: where it keeps things, what it may read, what runs its
// jobs and what the kernel has to confine them. For whoever looks into a log because something does not work.
#pragma once

#include <string>

#include "server/app/server.h"

namespace mote::server {

/// What the kernel has. Asked from any thread.
struct KernelFeatures {
    int landlock = 0;  ///< ABI version; 0: none
    bool seccomp = false;
};
KernelFeatures kernelFeatures();

/// A line each; warnings where something is missing.
void reportStart(const ServerSettings& settings, const std::string& device);

}  // namespace mote::server
