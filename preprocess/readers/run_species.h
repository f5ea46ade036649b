// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which species the particles of a run are divided into, for who has to choose one. A function without state.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "preprocess/job.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"

namespace mote::prep {

/// The names as ParticlesJob takes them, of all iterations of all files that can be listed, in the order in
/// which they are met; none of a format without species. Errors: as openParticleSource, of detecting the
/// format.
Result<std::vector<std::string>> runSpecies(const proto::ParticlesJob& job,
                                            const std::vector<std::filesystem::path>& inputs,
                                            Progress& progress);

}  // namespace mote::prep
