// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/load_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "protocol/scene/dataset.h"
#include "server/render/layers/mesh/cut_mesh.h"
#include "storage/mesh/mesh_file.h"

namespace mote::server {
namespace {

// Estimates of what is held while a mesh is loaded, in bytes: its arrays, what rays see of it, and Embree's
// tree while it is built.
constexpr std::uint64_t perVertex = (6 + 2 * 3) * sizeof(float);
constexpr std::uint64_t perTriangle = 2 * (3 * sizeof(float) + sizeof(std::uint32_t)) + 256;  // with its part
constexpr std::uint64_t perEdge = 4 * sizeof(float);
// The rest of the file is parts, which are counted with triangles, and intersections: 8 bytes there, and here
// the ends too.
constexpr std::uint64_t perByteBeside = 7;

/// Of the mesh's file, what is not of its vertices, triangles and edges.
std::uint64_t bytesBeside(const proto::Manifest& manifest) {
    const auto& mesh = manifest.mesh();
    const auto known = 4 * (6 * mesh.vertices() + 3 * mesh.triangles() + 4 * mesh.edges());
    const auto file = std::find_if(manifest.files().begin(), manifest.files().end(),
                                   [](const auto& each) { return each.name() == "mesh.h5"; });
    return file == manifest.files().end() || file->size() < known ? 0 : file->size() - known;
}

/// Of the vertices; of none, of one place.
Bounds boundsOf(const storage::SurfaceMesh& mesh) {
    if (mesh.positions.empty()) return {glm::dvec3(0.0), glm::dvec3(0.0)};
    Bounds bounds{glm::dvec3(mesh.positions[0]), glm::dvec3(mesh.positions[0])};
    for (const glm::dvec3 place : mesh.positions) bounds = bounds.united({place, place});
    return bounds;
}

Result<Loadable<render::MeshSurface>::Value> read(const storage::Catalogue::Entry& entry,
                                                  const HalfSpaces& clips,
                                                  const AnyLoadable::Cancelled& cancelled) {
    MOTE_ASSIGN_OR_RETURN(auto mesh, storage::readMesh(entry.directory, *entry.manifest));
    if (cancelled()) return Error{ErrorCode::cancelled, "dataset", "the mesh is no longer wanted"};
    if (clips.empty())
        return std::make_shared<const render::MeshSurface>(std::move(mesh), datasetBounds(*entry.manifest));
    mesh = render::cutMesh(mesh, clips);
    const Bounds bounds = boundsOf(mesh);
    return std::make_shared<const render::MeshSurface>(std::move(mesh), bounds);
}

}  // namespace

bool hasMesh(const proto::Manifest& manifest) {
    return manifest.kind() == "mesh" ||
           (manifest.kind() == "stipple" && manifest.stipple().domain() == proto::StippleManifest::SURFACE);
}

Result<Loadable<render::MeshSurface>> meshSurface(const storage::Catalogue::Entry& entry,
                                                  const HalfSpaces& clips) {
    if (!hasMesh(*entry.manifest)) {
        const auto& kind = entry.manifest->kind();
        return Error{ErrorCode::invalidArgument, "dataset",
                     kind == "stipple"
                         ? fmt::format("the points of \"{}\" lie on the plane: there is no mesh", entry.name)
                         : fmt::format("\"{}\" is of kind \"{}\", not a mesh", entry.name, kind)};
    }
    const auto& mesh = entry.manifest->mesh();
    // While it is cut there are the mesh before and after, and a triangle may become two.
    const std::uint64_t times = clips.empty() ? 1 : 3;
    const auto bytes = times * (mesh.vertices() * perVertex + mesh.triangles() * perTriangle +
                                mesh.edges() * perEdge + perByteBeside * bytesBeside(*entry.manifest));
    Loadable<render::MeshSurface> loadable(
        entry, [bytes](std::uint32_t) { return bytes; },
        [entry, clips](std::uint32_t, const AnyLoadable::Cancelled& cancelled) {
            return read(entry, clips, cancelled);
        });
    for (const auto& [normal, distance] : clips)
        loadable.key += fmt::format("{:a} {:a} {:a} {:a},", normal.x, normal.y, normal.z, distance);
    return loadable;
}

}  // namespace mote::server
