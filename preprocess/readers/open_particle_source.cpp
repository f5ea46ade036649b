// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/hdf5/h5_file.h"
#include "preprocess/readers/openpmd/source.h"
#include "preprocess/readers/particle_source.h"

namespace mote::prep {

Result<std::unique_ptr<ParticleSource>> openParticleSource(const proto::ParticlesJob& job,
                                                           const std::vector<std::filesystem::path>& inputs,
                                                           Progress& progress) {
    if (inputs.empty()) return Error{ErrorCode::invalidArgument, "inputs", "no input was given"};
    return openOpenpmd(inputs, job.species(), progress);
}

}  // namespace mote::prep
