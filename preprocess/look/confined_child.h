// SPDX-License-Identifier: GPL-3.0-or-later
//
// Work on foreign files in a process of its own, as jobs of a server have it: what it does cannot hurt
// anybody else. The child may read files and write none (Landlock, if the kernel has it), takes no more
// memory and processor time than it is given, runs no program, and ends with this process. Main thread,
// before there are others.
#pragma once

#include <cstdint>
#include <functional>

#include "preprocess/console.h"
#include "protocol/base/error.h"

namespace mote::prep {

struct Confinement {
    std::uint64_t memory = 0;   ///< bytes of data; 0: as memoryFor()
    std::uint64_t seconds = 0;  ///< of processor time; 0: as much as it takes
};

/// Runs `work`, whose result is the child's exit status, and waits for it. Errors: corrupt (the child died:
/// in one sentence, of what), resourceExhausted (it took too long; no process can be made), cancelled.
Result<int> runConfined(const std::function<int()>& work, const Confinement& confinement,
                        const CancelSignal& signal);

}  // namespace mote::prep
