// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <limits>

#include "storage/dataset_kind.h"
#include "storage/mesh/mesh_file.h"
#include "storage/verify.h"

namespace mote::storage {
namespace {

Status checkMesh(const proto::MeshManifest& mesh, const FileNames& files) {
    if (!files.contains("mesh.h5") || !files.contains("mesh.digest")) {
        return corrupt("", "mesh.h5 and mesh.digest are not among the dataset's files");
    }
    constexpr std::uint64_t most = std::numeric_limits<std::uint32_t>::max();
    if (mesh.vertices() < 3 || mesh.vertices() > most) return corrupt("vertices", "must be 3 to 2^32 - 1");
    if (mesh.triangles() < 1 || mesh.triangles() > most) return corrupt("triangles", "must be 1 to 2^32 - 1");
    if (mesh.edges() < 3 || mesh.edges() > 3 * mesh.triangles()) {
        return corrupt("edges", "must be at least 3, and no more than three a triangle");
    }
    if (mesh.bounds_min_size() != 3 || mesh.bounds_max_size() != 3) {
        return corrupt("boundsMin", "the bounds have three axes");
    }
    for (int axis = 0; axis < 3; ++axis) {
        if (std::isfinite(mesh.bounds_max(axis) - mesh.bounds_min(axis)) &&
            mesh.bounds_min(axis) <= mesh.bounds_max(axis)) {
            continue;
        }
        return corrupt("boundsMin", "the bounds must be finite, the least not above the greatest");
    }
    if (std::isfinite(mesh.area()) && mesh.area() > 0.0) return success();
    return corrupt("area", "must be finite and positive");
}

Status checkMesh(const proto::Manifest& manifest, const FileNames& files) {
    MOTE_RETURN_IF_ERROR(checkMesh(manifest.mesh(), files), "mesh");
    return success();
}

void verifyMesh(DatasetVerifier& verifier) {
    verifier.arrayFile(meshName, readMesh);
}

std::string describeMesh(const proto::Manifest& manifest) {
    const auto& mesh = manifest.mesh();
    // Beneath a stipple hierarchy, the request is that of the hierarchy.
    const auto made = manifest.request().has_mesh()
                          ? fmt::format("mesh     {}\n", manifest.request().mesh().input())
                          : std::string();
    std::string notes;
    for (const auto& note : mesh.notes()) notes += fmt::format("note     {}\n", note);
    return made + notes +
           fmt::format(
               "surface  {} vertices, {} triangles, {} edges, area {:.6g}\n"
               "bounds   [{:.6g}] to [{:.6g}]{}\n",
               mesh.vertices(), mesh.triangles(), mesh.edges(), mesh.area(),
               fmt::join(mesh.bounds_min(), ", "), fmt::join(mesh.bounds_max(), ", "),
               manifest.world_unit().empty() ? ", of an unknown unit" : " " + manifest.world_unit());
}

DatasetSummary summarizeMesh(const proto::Manifest& manifest) {
    const auto& mesh = manifest.mesh();
    return {fmt::format("{} vertices, {} triangles", mesh.vertices(), mesh.triangles()),
            {{"vertices", mesh.vertices()}, {"triangles", mesh.triangles()}, {"area", mesh.area()}}};
}

}  // namespace

const DatasetKind meshKind{"mesh",       &proto::Manifest::has_mesh, checkMesh, verifyMesh, describeMesh,
                           summarizeMesh};

}  // namespace mote::storage
