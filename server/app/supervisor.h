// SPDX-License-Identifier: GPL-3.0-or-later
//
// supervise: a server's life beyond its process. A small process that holds no data forks one that serves,
// waits for it, and where a signal ends that one (a fault in native code, the kernel short of memory) forks
// the next at once. Nothing is loaded again but data.
#pragma once

#include <cstddef>
#include <functional>

#include "server/frames/crash_record.h"

namespace mote::server {

/// Runs `serve` in a child process, and `again` whenever a signal ended that after it was ready. Signals that
/// ask a server to end (SIGTERM, SIGINT, SIGHUP) are passed on. A child does not outlive its supervisor.
///
/// Returns, in the supervisor alone, the last child's exit code, or 128 and a signal's number. No thread of
/// ours may run yet. Throws std::system_error where no process can be made.
int supervise(CrashRecord& record, const std::function<int(bool again)>& serve);

/// From now on whoever asks operator new for less than littleMemory and finds none ends the process, which
/// says so in the record: there is nothing to go on with, and what serves next goes on where this one was.
/// Who asks for more is thrown std::bad_alloc, as before.
void endWithoutMemory(CrashRecord& record);

inline constexpr std::size_t littleMemory = std::size_t{1} << 20;  ///< bytes

}  // namespace mote::server
