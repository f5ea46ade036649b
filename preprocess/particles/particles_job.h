// SPDX-License-Identifier: GPL-3.0-or-later
//
// The particles job: from a run to a dataset of kind "particles". Called from one thread in each of the
// processes that do it together; works on as many threads as it is given. The same request and input give the
// same bytes, whatever the processes, the threads and the memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/kept_notes.h"
#include "preprocess/readers/particle_source.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::prep {

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

/// What steps are to a live dataset (storage/grow_dataset.h).
struct LiveSteps {
    std::optional<proto::Manifest> base = {};  ///< of the dataset that gets them; none: they begin it
    std::filesystem::path place;               ///< of that dataset
    std::optional<std::vector<std::size_t>> steps = {};  ///< of the source; none: those of the request
    std::optional<std::int64_t> firstIteration = {};  ///< they are numbered from here on; none: as the source
    bool live = true;                                 ///< more may come
};

/// Makes a dataset as runParticlesJob does, whose manifest tells of the steps of `live.base` too and whose
/// files are those of further steps alone, under their later names. Bounds of the whole run are those of the
/// base. Errors: also invalidArgument (a plot or a run that does not go on).
Result<proto::Manifest> makeLiveSteps(const proto::JobRequest& request, ParticleSource& source,
                                      const std::vector<std::filesystem::path>& inputs,
                                      const std::filesystem::path& output, const LiveSteps& live,
                                      const JobResources& resources, KeptNotes& progress);

/// A dataset of ours, or by openParticleSource. Errors: as that; notFound (a dataset without columns).
Result<std::unique_ptr<ParticleSource>> openRun(const proto::ParticlesJob& job,
                                                const std::vector<std::filesystem::path>& inputs,
                                                Progress& progress);

/// Opens the inputs by openRun, then as above.
Result<proto::Manifest> runParticlesJob(const proto::JobRequest& request,
                                        const std::vector<std::filesystem::path>& inputs,
                                        const std::filesystem::path& output, const JobResources& resources,
                                        Progress& progress);

}  // namespace mote::prep
