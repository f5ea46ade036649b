// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/mesh/mesh_file.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <utility>

#include "storage/arrays/array_file.h"

namespace mote::storage {
namespace {

static_assert(sizeof(glm::vec3) == 3 * sizeof(float) && sizeof(MeshEdge) == 4 * sizeof(std::uint32_t));

/// Rows of numbers as the array of numbers that lies on the disk.
template <class T, class Row>
std::span<const T> flat(const std::vector<Row>& rows) {
    return {reinterpret_cast<const T*>(rows.data()), rows.size() * sizeof(Row) / sizeof(T)};
}

template <class Row, class T>
std::vector<Row> rowsOf(std::span<const T> values) {
    const auto* const first = reinterpret_cast<const Row*>(values.data());
    return {first, first + values.size_bytes() / sizeof(Row)};
}

constexpr const char* partName = "/mesh/part";
constexpr const char* intersectionName = "/mesh/intersection";

/// Reads `rows` from the array of this name, as long as nothing went wrong before.
template <class T, class Row>
Status readRows(const ArrayFile& file, const char* name, std::uint64_t count, std::vector<Row>& rows) {
    MOTE_ASSIGN_OR_RETURN(const auto values, file.get<T>(name, {count, sizeof(Row) / sizeof(T)}));
    rows = rowsOf<Row>(values);
    return success();
}

/// Least and greatest coordinates of its vertices.
std::pair<glm::vec3, glm::vec3> boundsOf(const SurfaceMesh& mesh) {
    glm::vec3 least(mesh.positions.empty() ? glm::vec3(0.0F) : mesh.positions.front());
    glm::vec3 greatest(least);
    for (const auto& position : mesh.positions) {
        least = glm::min(least, position);
        greatest = glm::max(greatest, position);
    }
    return {least, greatest};
}

bool boundsAreTold(const SurfaceMesh& mesh, const proto::MeshManifest& manifest) {
    const auto [least, greatest] = boundsOf(mesh);
    bool same = manifest.bounds_min_size() == 3 && manifest.bounds_max_size() == 3;
    for (int axis = 0; same && axis < 3; ++axis) {
        same = manifest.bounds_min(axis) == static_cast<double>(least[axis]) &&
               manifest.bounds_max(axis) == static_cast<double>(greatest[axis]);
    }
    return same;
}

}  // namespace

Status writeMesh(const std::filesystem::path& directory, const SurfaceMesh& mesh) {
    ArrayFileContent content;
    content.groups = {"/mesh"};
    const auto add = [&]<class T>(const char* name, std::uint64_t rows, std::span<const T> values) {
        content.arrays.push_back(arrayContent<T>(name, {rows, rows == 0 ? 1 : values.size() / rows}, values));
    };
    add("/mesh/position", mesh.positions.size(), flat<float>(mesh.positions));
    add("/mesh/normal", mesh.normals.size(), flat<float>(mesh.normals));
    add("/mesh/triangle", mesh.triangles.size(), flat<std::uint32_t>(mesh.triangles));
    add("/mesh/edge", mesh.edges.size(), flat<std::uint32_t>(mesh.edges));
    if (!mesh.parts.empty()) {
        content.arrays.push_back(
            arrayContent<std::uint32_t>(partName, {mesh.parts.size()}, std::span(mesh.parts)));
    }
    if (!mesh.intersections.empty())
        add(intersectionName, mesh.intersections.size(), flat<std::uint32_t>(mesh.intersections));
    return writeArrayFile(directory, meshName, content);
}

proto::MeshManifest describeMesh(const SurfaceMesh& mesh) {
    proto::MeshManifest manifest;
    manifest.set_vertices(mesh.positions.size());
    manifest.set_triangles(mesh.triangles.size());
    manifest.set_edges(mesh.edges.size());
    const auto [least, greatest] = boundsOf(mesh);
    for (int axis = 0; axis < 3; ++axis) {
        manifest.add_bounds_min(least[axis]);
        manifest.add_bounds_max(greatest[axis]);
    }
    double area = 0.0;
    for (const auto& [a, b, c] : mesh.triangles) {
        const glm::dvec3 origin(mesh.positions[a]);
        area += 0.5 * glm::length(glm::cross(glm::dvec3(mesh.positions[b]) - origin,
                                             glm::dvec3(mesh.positions[c]) - origin));
    }
    manifest.set_area(area);
    return manifest;
}

Result<SurfaceMesh> readMesh(const PathBeneath& directory, const proto::Manifest& manifest) {
    if (!manifest.has_mesh()) {
        return Error{ErrorCode::invalidArgument, directory.string(), "is a dataset without a mesh"};
    }
    MOTE_ASSIGN_OR_RETURN(const auto file, ArrayFile::open(directory, manifest, meshName));
    const auto& described = manifest.mesh();
    SurfaceMesh mesh;
    MOTE_RETURN_IF_ERROR(readRows<float>(file, "/mesh/position", described.vertices(), mesh.positions));
    MOTE_RETURN_IF_ERROR(readRows<float>(file, "/mesh/normal", described.vertices(), mesh.normals));
    MOTE_RETURN_IF_ERROR(
        readRows<std::uint32_t>(file, "/mesh/triangle", described.triangles(), mesh.triangles));
    MOTE_RETURN_IF_ERROR(readRows<std::uint32_t>(file, "/mesh/edge", described.edges(), mesh.edges));
    if (file.has(partName)) {
        MOTE_ASSIGN_OR_RETURN(const auto parts, file.get<std::uint32_t>(partName, {described.triangles()}));
        mesh.parts.assign(parts.begin(), parts.end());
    }
    if (file.has(intersectionName)) {
        MOTE_RETURN_IF_ERROR(
            readRows<std::uint32_t>(file, intersectionName, ArrayFile::any, mesh.intersections));
    }
    MOTE_RETURN_IF_ERROR(file.check());
    const auto checked = checkSurfaceMesh(mesh);
    if (checked.ok() && !boundsAreTold(mesh, described)) {
        return Error{ErrorCode::corrupt, (directory / "manifest.json").string(),
                     "mesh.boundsMin and boundsMax are not those of the vertices"};
    }
    if (checked.ok()) return mesh;
    return Error{checked.error().code, file.where(checked.error().where), checked.error().message};
}

}  // namespace mote::storage
