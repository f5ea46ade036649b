// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/load_mesh.h"

#include <fmt/format.h>

#include <utility>

#include "protocol/scene/dataset.h"
#include "storage/mesh/mesh_file.h"

namespace mote::server {
namespace {

// Estimates of what is held while a mesh is loaded, in bytes: its arrays, what rays see of it, and Embree's
// tree while it is built.
constexpr std::uint64_t perVertex = 6 * sizeof(float) + 2 * 3 * sizeof(float);
constexpr std::uint64_t perTriangle = 2 * (3 * sizeof(float) + sizeof(std::uint32_t)) + 256;  // with its part
constexpr std::uint64_t perEdge = 4 * sizeof(float);

Result<Loadable<render::MeshSurface>::Value> read(const storage::Catalogue::Entry& entry,
                                                  const AnyLoadable::Cancelled& cancelled) {
    MOTE_ASSIGN_OR_RETURN(auto mesh, storage::readMesh(entry.directory, *entry.manifest));
    if (cancelled()) return Error{ErrorCode::cancelled, "dataset", "the mesh is no longer wanted"};
    return std::make_shared<const render::MeshSurface>(std::move(mesh), datasetBounds(*entry.manifest));
}

}  // namespace

Result<Loadable<render::MeshSurface>> meshSurface(const storage::Catalogue::Entry& entry) {
    if (entry.manifest->kind() != "mesh") {
        return Error{ErrorCode::invalidArgument, "dataset",
                     fmt::format("\"{}\" is of kind \"{}\", not a mesh", entry.name, entry.manifest->kind())};
    }
    const auto& mesh = entry.manifest->mesh();
    const auto bytes = mesh.vertices() * perVertex + mesh.triangles() * perTriangle + mesh.edges() * perEdge;
    return Loadable<render::MeshSurface>(
        entry, [bytes](std::uint32_t) { return bytes; },
        [entry](std::uint32_t, const AnyLoadable::Cancelled& cancelled) { return read(entry, cancelled); });
}

}  // namespace mote::server
