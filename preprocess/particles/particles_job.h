// SPDX-License-Identifier: GPL-3.0-or-later
//
// The particles job: from a run to a dataset of kind "particles". Called from one thread in each of the
// processes that do it together; works on as many threads as it is given. The same request and input give the
// same bytes, whatever the processes, the threads and the memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/readers/particle_source.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"

namespace mote::prep {

inline constexpr std::uint32_t defaultLeafCapacity = 32;
inline constexpr std::uint32_t defaultMaxLevel = 10;
inline constexpr std::uint32_t defaultVolumeLevel = 6;

/// What can be said of a request before its inputs are looked at. Errors: invalidArgument with the field's
/// path.
Status checkParticlesJob(const proto::ParticlesJob& job);

/// Makes `output`, which appears by one rename, from `source`, which was opened from `inputs`. Returns its
/// manifest; its files only on rank 0. Errors: invalidArgument, notFound (an axis that the run does not
/// have), alreadyExists, permissionDenied, resourceExhausted (memory, disk), cancelled, and the source's own.
Result<proto::Manifest> runParticlesJob(const proto::JobRequest& request, ParticleSource& source,
                                        const std::vector<std::filesystem::path>& inputs,
                                        const std::filesystem::path& output, const JobResources& resources,
                                        Progress& progress);

/// Opens the inputs by openParticleSource, then as above.
Result<proto::Manifest> runParticlesJob(const proto::JobRequest& request,
                                        const std::vector<std::filesystem::path>& inputs,
                                        const std::filesystem::path& output, const JobResources& resources,
                                        Progress& progress);

}  // namespace mote::prep
