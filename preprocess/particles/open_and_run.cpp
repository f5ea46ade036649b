// SPDX-License-Identifier: GPL-3.0-or-later
//
// Apart from the rest of the job, so that only this needs the readers.
#include "preprocess/parallel/communicator.h"
#include "preprocess/particles/particles_job.h"

namespace mote::prep {

Result<proto::Manifest> runParticlesJob(const proto::JobRequest& request,
                                        const std::vector<std::filesystem::path>& inputs,
                                        const std::filesystem::path& output, const JobResources& resources,
                                        Progress& progress) {
    MOTE_RETURN_IF_ERROR(checkParticlesJob(request.particles()));
    auto source = openParticleSource(request.particles(), inputs, progress);
    const Status opened = source.ok() ? success() : Status(source.error());
    MOTE_RETURN_IF_ERROR(resources.ranks ? agree(*resources.ranks, opened) : opened);
    return runParticlesJob(request, **source, inputs, output, resources, progress);
}

}  // namespace mote::prep
