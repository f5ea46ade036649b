// SPDX-License-Identifier: GPL-3.0-or-later
//
// ChildEnd: how a supervised program came to its end. The child leads a process group of its own; SIGTERM and
// SIGCHLD are blocked.
#pragma once

#include <signal.h>
#include <sys/types.h>

#include <cstdint>
#include <string>

namespace mote::server {

/// How the program ended.
struct ChildEnd {
    int status = 0;     ///< as waitpid has it
    bool late = false;  ///< its time limit ended it
};

/// Waits for the child's end, hands SIGTERM on, or sends it when `timeLimit` seconds are over (0: never), and
/// sees to it that it is obeyed. Then nothing of the child is left.
ChildEnd waitForEnd(pid_t child, const sigset_t& signals, std::uint32_t timeLimit);

/// What the job came to, in a line: "exit CODE", "signal NUMBER" or "timeout SECONDS".
std::string resultOf(const ChildEnd& end, std::uint32_t timeLimit);

}  // namespace mote::server
