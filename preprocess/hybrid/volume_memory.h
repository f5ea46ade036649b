// SPDX-License-Identifier: GPL-3.0-or-later
//
// How a volume job divides the memory that it may take. Pure functions, but for the machine's own size.
#pragma once

#include <cstdint>

#include "preprocess/hybrid/volume_plan.h"
#include "protocol/scene/error.h"

namespace mote::prep {

struct VolumeMemory {
    std::uint32_t slices = 0;  ///< of the source or the error grid, worked on at once
};

/// `limit` is this process', 0 for three quarters of the machine's memory; on `threads` threads. Errors:
/// resourceExhausted, where not even a few slices fit, with what is missing. What each takes:
/// docs/HYBRID_VOLUMES.md.
Result<VolumeMemory> planMemory(const VolumePlan& plan, std::uint64_t limit, int threads);

}  // namespace mote::prep
