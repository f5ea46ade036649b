// SPDX-License-Identifier: GPL-3.0-or-later
//
// Apart from the rest of the job, so that only this needs the readers.
#include "preprocess/hybrid/volume_job.h"

namespace mote::prep {

Result<proto::Manifest> runVolumeJob(const proto::JobRequest& request,
                                     const std::vector<std::filesystem::path>& inputs,
                                     const std::filesystem::path& output, const JobResources& resources,
                                     Progress& progress) {
    const OpenVolume open = [&](std::size_t index) {
        return openVolumeSource(request.volume().source(), inputs[index], progress);
    };
    return runVolumeJob(request, open, inputs, output, resources, progress);
}

}  // namespace mote::prep
