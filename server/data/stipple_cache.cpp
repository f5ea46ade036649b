// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/stipple_cache.h"

#include <algorithm>
#include <iterator>

#include "storage/mesh/mesh_file.h"
#include "storage/stipple/hierarchy_file.h"

namespace mote::server {
namespace {

Bounds boundsOf(const proto::MeshManifest& mesh) {
    Bounds bounds{};
    for (int i = 0; i < 3; ++i) {
        bounds.min[i] = mesh.bounds_min(i);
        bounds.max[i] = mesh.bounds_max(i);
    }
    return bounds;
}

Result<StippleCache::Surface> read(const storage::Catalogue::Entry& entry) {
    const auto& manifest = *entry.manifest;
    if (manifest.kind() != "stipple") {
        return Error{
            ErrorCode::invalidArgument, "dataset",
            "\"" + entry.name + "\" is of kind \"" + manifest.kind() + "\", not a stipple hierarchy"};
    }
    if (manifest.stipple().domain() != proto::StippleManifest::SURFACE) {
        return Error{ErrorCode::unsupported, "dataset",
                     "its points lie on the plane: they stipple an image, which is not given"};
    }
    auto hierarchy = storage::readHierarchy(entry.directory, manifest);
    if (!hierarchy.ok()) return hierarchy.error();
    const auto mesh = storage::readMesh(entry.directory, manifest);
    if (!mesh.ok()) return mesh.error();
    return std::make_shared<const render::StippleSurface>(
        render::StippleReplay(*std::move(hierarchy)), render::SurfaceRays(mesh->positions, mesh->triangles),
        boundsOf(manifest.mesh()), manifest.stipple().area());
}

}  // namespace

Result<StippleCache::Surface> StippleCache::surface(const storage::Catalogue::Entry& entry) {
    const auto found = std::find_if(kept_.begin(), kept_.end(),
                                    [&](const Kept& kept) { return kept.manifest == entry.manifest; });
    if (found != kept_.end()) {
        kept_.splice(kept_.begin(), kept_, found);
        return kept_.front().surface;
    }
    auto made = read(entry);
    if (!made.ok()) return made;
    kept_.push_front({entry.manifest, *made});
    if (kept_.size() > mostSurfaces) kept_.pop_back();
    return made;
}

}  // namespace mote::server
