// SPDX-License-Identifier: GPL-3.0-or-later
//
// Reading a mesh from any of the formats, each of which may be gzipped. Foreign files are untrusted: nothing
// of them throws or aborts, and memory is taken only for what is there. Any thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "preprocess/job.h"
#include "preprocess/mesh/triangle_mesh.h"
#include "protocol/base/error.h"

namespace mote::prep {

struct ReadMesh {
    TriangleMesh mesh;  ///< welded; at least one triangle
    MeshCounts counts;
};

/// The format is told from the content, else from the name's ending. `limit`: bytes that the file may have,
/// inflated. Errors: notFound, permissionDenied, unsupported (no mesh format, no triangles that are kept),
/// corrupt with file and line or byte, resourceExhausted (larger than the limit), cancelled.
Result<ReadMesh> readMesh(const std::filesystem::path& path, std::uint64_t limit, Progress& progress);

/// ".obj" of "Skull.OBJ.gz".
std::string meshEnding(const std::filesystem::path& path);

/// One sentence of what was put right; empty if all was well.
std::string describeRepairs(const MeshCounts& counts);

}  // namespace mote::prep
