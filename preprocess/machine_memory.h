// SPDX-License-Identifier: GPL-3.0-or-later
//
// How much memory a job may take. A pure function but for the machine's own size.
#pragma once

#include <unistd.h>

#include <cstdint>

namespace mote::prep {

/// Bytes: the limit that the job was given, or three quarters of the machine's memory where it is 0.
inline std::uint64_t memoryFor(std::uint64_t limit) {
    if (limit > 0) return limit;
    const long pages = ::sysconf(_SC_PHYS_PAGES);
    const long bytes = ::sysconf(_SC_PAGESIZE);
    if (pages <= 0 || bytes <= 0) return 0;
    return static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(bytes) / 4 * 3;
}

}  // namespace mote::prep
