// SPDX-License-Identifier: GPL-3.0-or-later
//
// The stipple job on a mesh: a dataset of kind "stipple" whose hierarchy lies on a surface, with the mesh
// beside it. Called from one thread. The same request and file give the same bytes on any number of threads.
#pragma once

#include <filesystem>

#include "preprocess/progress.h"
#include "preprocess/stipple/stipple_job.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"

namespace mote::prep {

/// Makes `output`, which appears by one rename, from the mesh in the file `input`. Returns its manifest.
/// Errors: those of readMesh (preprocess/mesh/read_mesh.h), invalidArgument, alreadyExists, permissionDenied,
/// resourceExhausted (memory, disk), cancelled.
Result<proto::Manifest> runSurfaceJob(const proto::JobRequest& request, const std::filesystem::path& input,
                                      const std::filesystem::path& output, const JobResources& resources,
                                      Progress& progress);

}  // namespace mote::prep
