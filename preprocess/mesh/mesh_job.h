// SPDX-License-Identifier: GPL-3.0-or-later
//
// The mesh job: from a foreign mesh, or a surface of a volume, to a dataset of kind "mesh". Called from one
// thread. The same file gives the same bytes.
#pragma once

#include <cstdint>
#include <filesystem>

#include "preprocess/job.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::prep {

/// Bytes that a mesh file may have, inflated, for a job of so much memory: in memory it takes up to eighteen
/// times as much (a PLY file of one-byte coordinates, which are doubles while it is read).
std::uint64_t meshFileLimit(std::uint64_t memory);

/// Makes `output`, which appears by one rename, from `input`. Returns its manifest. Errors: those of readMesh
/// (read_mesh.h) or of isosurface and openVolumeSource, alreadyExists, permissionDenied, resourceExhausted
/// (memory, disk), cancelled.
Result<proto::Manifest> runMeshJob(const proto::JobRequest& request, const std::filesystem::path& input,
                                   const std::filesystem::path& output, const JobResources& resources,
                                   Progress& progress);

}  // namespace mote::prep
