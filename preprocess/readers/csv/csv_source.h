// SPDX-License-Identifier: GPL-3.0-or-later
//
// Tables in text with a line of names: comma, semicolon, tab or blanks between the fields; one file a step.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "preprocess/readers/particle_source.h"

namespace mote::prep {

/// Steps in the order of the numbers in the files' names. `mass` in eV/c^2, 0: unknown. Errors: notFound,
/// corrupt, unsupported, invalidArgument, cancelled.
Result<std::unique_ptr<ParticleSource>> openCsv(const std::vector<std::filesystem::path>& files, double mass,
                                                Progress& progress);

}  // namespace mote::prep
