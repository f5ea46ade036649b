// SPDX-License-Identifier: GPL-3.0-or-later
//
// What jobs of all kinds share: the resources that they may use, and Progress, by which they say how far they
// are and learn that they should stop. A Progress has one owner; report() and cancelled() may be called from
// any thread.
#pragma once

#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "protocol/base/error.h"

namespace mote::prep {

/// Bytes: the limit that the job was given, or three quarters of the machine's memory if it is 0.
inline std::uint64_t memoryFor(std::uint64_t limit) {
    if (limit > 0) return limit;
    const long pages = ::sysconf(_SC_PHYS_PAGES);
    const long bytes = ::sysconf(_SC_PAGESIZE);
    if (pages <= 0 || bytes <= 0) return 0;
    return static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(bytes) / 4 * 3;
}

class Communicator;

/// What a job of any kind may use. It changes how the job works, and never what it makes.
struct JobResources {
    int threads = 0;                ///< 0: as many as there are cores
    std::uint64_t memory = 0;       ///< bytes that this process may take; 0: three quarters of the machine's
    Communicator* ranks = nullptr;  ///< the processes that do this job together; null: this one alone
};

class Progress {
  public:
    virtual ~Progress() = default;
    /// `fraction` of the whole job, 0 to 1, never falling; `phase` for people: "reading step 3 of 10".
    virtual void report(double fraction, std::string_view phase) = 0;
    /// Something the user should know and that is no error: "12 particles lie outside the bounds".
    virtual void note(std::string_view sentence) = 0;
    /// True once the job should stop: asked at least every few hundred milliseconds.
    virtual bool cancelled() const = 0;
};

}  // namespace mote::prep
