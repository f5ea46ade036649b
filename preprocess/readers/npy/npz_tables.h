// SPDX-License-Identifier: GPL-3.0-or-later
//
// Archives of NumPy arrays that are read whole: those with an array p0c, in units of which their momenta are
// (numpy.savez of xsuite's Particles.to_dict()). Functions without state.
#pragma once

#include "preprocess/readers/particle_reader.h"

namespace mote::prep {

bool isScaledNpz(const std::filesystem::path& path);

/// Errors: those of openHeld.
Result<std::unique_ptr<ParticleSource>> openScaledNpz(const AskedRun& run, Progress& progress);

}  // namespace mote::prep
