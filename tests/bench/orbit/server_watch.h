// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a running process costs, as the kernel counts it. Pure functions, but for /proc.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>

namespace mote::bench {

/// Processor time since it began, all threads. Throws std::runtime_error where there is no such process.
std::chrono::duration<double> processorTime(pid_t process);

struct Memory {
    std::uint64_t anonymous = 0;  ///< bytes of its own
    std::uint64_t mapped = 0;     ///< bytes of files, which the kernel may take back
};
/// Throws std::runtime_error.
Memory residentMemory(pid_t process);

}  // namespace mote::bench
