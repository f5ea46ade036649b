// SPDX-License-Identifier: GPL-3.0-or-later
//
// H5Part runs: HDF5 files whose groups Step#0, Step#1, ... hold one dataset a column, as OPAL and others
// write.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "preprocess/readers/hdf5/h5_file.h"
#include "preprocess/readers/particle_source.h"

namespace mote::prep {

/// True where a group Step#N stands in the root.
bool looksLikeH5Part(const H5File& file);

/// All files as one series. `mass` in eV/c^2, 0: as the file says. Errors: notFound, unsupported, corrupt,
/// cancelled.
Result<std::unique_ptr<ParticleSource>> openH5Part(const std::vector<std::filesystem::path>& files,
                                                   double mass, Progress& progress);

}  // namespace mote::prep
