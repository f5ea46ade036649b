// SPDX-License-Identifier: GPL-3.0-or-later
//
// A synthetic beam run in which a halo really forms: a mismatched 6D waterbag in a periodic FODO channel with
// space charge by the particle-core model. Written as openPMD 1.1 HDF5 in chunks, reproducible from its seed.
// Called from one thread; works on all that oneTBB grants.
#pragma once

#include <cstdint>
#include <filesystem>

#include "preprocess/job.h"
#include "preprocess/synth/channel_plan.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::prep {

struct BeamRun {
    std::uint64_t particles = 0;
    std::uint64_t seed = 0;
    std::size_t chunkRows = std::size_t{1} << 18;  ///< particles in memory at once
};

/// Writes the run to `output`. Errors: as synthesizeBeam.
Status writeBeamRun(const ChannelPlan& plan, const BeamRun& run, const std::filesystem::path& output,
                    Progress& progress);

/// Writes the run to `output`, which appears by one rename. Errors: invalidArgument, alreadyExists,
/// permissionDenied, resourceExhausted (disk full), cancelled.
Status synthesizeBeam(const proto::SynthBeamJob& job, const std::filesystem::path& output,
                      Progress& progress);

}  // namespace mote::prep
