// SPDX-License-Identifier: GPL-3.0-or-later
//
// openPMD runs in HDF5 (versions 1.0 to 2.0, with or without the BeamPhysics extension), one or several
// files.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "preprocess/readers/particle_source.h"

namespace mote::prep {

/// Opens all files as one series; `species` as in ParticlesJob. Errors: notFound, unsupported, corrupt,
/// invalidArgument (several species and none named), cancelled.
Result<std::unique_ptr<ParticleSource>> openOpenpmd(const std::vector<std::filesystem::path>& files,
                                                    const std::string& species, Progress& progress);

}  // namespace mote::prep
