// SPDX-License-Identifier: GPL-3.0-or-later
//
// mesh.h5 and mesh.digest of a dataset of kind "mesh", or of kind "stipple" on a surface (docs/FORMAT.md): a
// SurfaceMesh on disk. Functions without state; writing has one thread at a time in a process (HDF5), reading
// any.
#pragma once

#include <filesystem>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "storage/files/path_beneath.h"
#include "storage/mesh/surface_mesh.h"

namespace mote::storage {

inline constexpr const char* meshName = "mesh";

/// Makes both files in `directory`. Errors: as writeArrayFile.
Status writeMesh(const std::filesystem::path& directory, const SurfaceMesh& mesh);

/// What the manifest says of it.
proto::MeshManifest describeMesh(const SurfaceMesh& mesh);

/// Reads all of it, every byte held to its digest, and checks it (checkSurfaceMesh) and that it has the
/// manifest's vertices, triangles and bounds. Errors: notFound, corrupt (with file and array),
/// invalidArgument (a dataset without a mesh).
Result<SurfaceMesh> readMesh(const PathBeneath& directory, const proto::Manifest& manifest);

}  // namespace mote::storage
