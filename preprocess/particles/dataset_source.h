// SPDX-License-Identifier: GPL-3.0-or-later
//
// A dataset of kind "particles" as a run: its columns are read instead of the source that it was made from,
// point after point. Values are offset + float, and particles that the plot left out are not there; the
// statistics of its steps are handed on as they are.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "preprocess/readers/particle_source.h"

namespace mote::prep {

/// Whether inputs of a job name a dataset.
bool isDataset(const std::vector<std::filesystem::path>& inputs);

/// Errors: notFound (no columns: says how to make them), invalidArgument (a choice of lost particles, a
/// species or a format that the dataset does not have), as storage::readManifest.
Result<std::unique_ptr<ParticleSource>> openDataset(const proto::ParticlesJob& job,
                                                    const std::filesystem::path& directory);

}  // namespace mote::prep
