// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which reader a run's files need, by the name that the user gives or by what the files hold. Functions
// without state.
#pragma once

#include <filesystem>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/readers/input_files.h"
#include "preprocess/readers/particle_reader.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::prep {

/// A run's files, all of one format.
struct ParticleFiles {
    const ParticleReader* reader = nullptr;  ///< not null
    std::vector<std::filesystem::path> paths;
};

/// The files of the format that the job names, else of that of the first file that is named and read. Of a
/// folder or a pattern it is that of most files; those of other formats are left out, with a note. Errors:
/// notFound, unsupported (with what may be done), invalidArgument (an unknown name, files of different
/// formats, in a folder as many of one as of another).
Result<ParticleFiles> detectFormat(const proto::ParticlesJob& job, const std::vector<InputFile>& files,
                                   Progress& progress);

/// The names as ParticlesJob takes them, of all iterations of all files that can be listed, in the order in
/// which they are met; none of a format without species. Errors: as openParticleSource, of detecting the
/// format.
Result<std::vector<std::string>> runSpecies(const proto::ParticlesJob& job,
                                            const std::vector<std::filesystem::path>& inputs,
                                            Progress& progress);

}  // namespace mote::prep
