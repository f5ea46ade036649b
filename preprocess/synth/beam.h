// SPDX-License-Identifier: GPL-3.0-or-later
//
// A synthetic beam run in which a halo really forms: a mismatched 6D waterbag in a periodic FODO channel with
// space charge by the particle-core model. Written as openPMD 1.1 HDF5 in chunks, reproducible from its seed.
#pragma once

#include <filesystem>

#include "preprocess/progress.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"

namespace mote::prep {

/// Writes the run to `output`, which appears by one rename. Errors: invalidArgument, alreadyExists,
/// permissionDenied, resourceExhausted (disk full), cancelled.
Status synthesizeBeam(const proto::SynthBeamJob& job, const std::filesystem::path& output,
                      Progress& progress);

}  // namespace mote::prep
