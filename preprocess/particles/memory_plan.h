// SPDX-License-Identifier: GPL-3.0-or-later
//
// How a job divides the memory that it may take. Pure functions, but for the machine's own size.
#pragma once

#include <cstdint>

#include "preprocess/particles/step_builder.h"

namespace mote::prep {

struct MemoryPlan {
    std::uint64_t needed = 0;     ///< bytes without which the step cannot be built
    std::uint64_t particles = 0;  ///< bytes left for particles in memory
    std::uint64_t kept = 0;       ///< bytes left for what was read and will be needed again
};

/// The plan for a step of so many particles; `limit` is this process', 0 for three quarters of the machine's
/// memory. Figures measured: docs/JOBS.md.
MemoryPlan planMemory(std::uint64_t particles, const StepOptions& options, std::uint64_t limit, int threads);

}  // namespace mote::prep
