// SPDX-License-Identifier: GPL-3.0-or-later
//
// The volume job: from scalar volumes, one a step, to a dataset of kind "hybrid" (section 3.2 of the
// dissertation; docs/HYBRID_VOLUMES.md). Called from one thread on every rank; works on as many as it is
// given. The same request and inputs give the same bytes, whatever the ranks, the threads and the memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/volume/volume_source.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::prep {

/// Opens the volume of an input, by its index.
using OpenVolume = std::function<Result<std::unique_ptr<VolumeSource>>(std::size_t)>;

/// Makes `output`, which appears by one rename, from `inputs`. Returns its manifest. Errors: invalidArgument
/// (the request, volumes of different sizes), alreadyExists, permissionDenied, resourceExhausted (memory,
/// disk), cancelled, and the sources' own.
Result<proto::Manifest> runVolumeJob(const proto::JobRequest& request,
                                     const std::vector<std::filesystem::path>& inputs,
                                     const std::filesystem::path& output, const JobResources& resources,
                                     Progress& progress);
/// The same with sources that come from elsewhere; `inputs` are their names.
Result<proto::Manifest> runVolumeJob(const proto::JobRequest& request, const OpenVolume& open,
                                     const std::vector<std::filesystem::path>& inputs,
                                     const std::filesystem::path& output, const JobResources& resources,
                                     Progress& progress);

}  // namespace mote::prep
