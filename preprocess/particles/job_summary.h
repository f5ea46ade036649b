// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a particles job knows only when all of its steps are written: histograms of densities on the scale of
// all steps, and how many particles were left out. Functions without state.
#pragma once

#include <cstdint>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/particles/bounds_rule.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "storage/particles/step_file.h"

namespace mote::prep {

/// Particles by the scaled log density of their leaf, from the file of a step with so many leaves. Errors:
/// internal, cancelled.
Result<std::vector<std::uint64_t>> densityHistogram(const storage::StepFile& file, std::uint64_t leaves,
                                                    const Range& densities, const Progress& progress);

/// Notes what the steps leave out; `others`: particles that are not lost, of a plot of those that are.
void noteLeftOut(const proto::ParticlesManifest& particles, bool boundsGiven, std::uint64_t others,
                 Progress& progress);

}  // namespace mote::prep
