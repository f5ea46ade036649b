// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/ball_surface.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <utility>

#include "storage/dataset_writer.h"
#include "storage/mesh/mesh_file.h"
#include "storage/stipple/stipple_hierarchy.h"
#include "storage/storage_error.h"
#include "tests/support/generated_mesh.h"

namespace mote::test {
namespace {

constexpr double pi = std::numbers::pi;

/// Rings of vertices; facets leave the ball by less than radius * (pi / rings)^2 / 2.
void addBall(storage::SurfaceMesh& mesh, double radius) {
    constexpr std::uint32_t rings = 180, columns = 2 * rings;
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (std::uint32_t ring = 0; ring <= rings; ++ring) {
        for (std::uint32_t column = 0; column < columns; ++column) {
            const double theta = pi * ring / rings, phi = 2.0 * pi * column / columns;
            mesh.positions.emplace_back(radius * std::sin(theta) * std::cos(phi), radius * std::cos(theta),
                                        radius * std::sin(theta) * std::sin(phi));
        }
    }
    for (std::uint32_t ring = 0; ring < rings; ++ring) {
        for (std::uint32_t column = 0; column < columns; ++column) {
            const std::uint32_t a = first + ring * columns + column;
            const std::uint32_t b = first + ring * columns + (column + 1) % columns;
            mesh.triangles.push_back({a, b, a + columns});
            mesh.triangles.push_back({b, b + columns, a + columns});
        }
    }
}

/// A number of [0, 1) for an index, such that those of any first n indices are spread evenly (van der
/// Corput).
double spread(std::uint32_t index) {
    double sum = 0.0;
    for (double digit = 0.5; index != 0; index >>= 1, digit *= 0.5) sum += (index & 1U) * digit;
    return sum;
}

/// Points in the order in which they are added: the first is removed last.
storage::StippleHierarchy hierarchyOf(std::vector<glm::vec3> positions, std::vector<glm::vec3> normals) {
    storage::StippleHierarchy hierarchy;
    const auto count = static_cast<std::uint32_t>(positions.size());
    hierarchy.positions = std::move(positions);
    hierarchy.normals = std::move(normals);
    for (std::uint32_t i = 0; i < count; ++i) hierarchy.removal.push_back(count - 1 - i);
    hierarchy.deathArea.assign(count, 1.0F);
    hierarchy.locked.assign(count, 1);
    hierarchy.movesBegin.assign(count + 1, 0);
    return hierarchy;
}

/// Points on the unit ball.
std::vector<glm::vec3> ballPoints(std::uint32_t points) {
    std::vector<glm::vec3> positions;
    for (std::uint32_t i = 0; i < points; ++i) {
        // Equal steps of height are equal areas; the golden ratio spreads the angles.
        const double height = 1.0 - 2.0 * spread(i + 1), angle = 2.0 * pi * i * std::numbers::phi;
        const double r = std::sqrt(1.0 - height * height);
        positions.push_back(glm::normalize(glm::vec3(r * std::cos(angle), height, r * std::sin(angle))));
    }
    return positions;
}

void require(const Status& status) {
    if (!status.ok()) throw storage::StorageError(status.error());
}

render::SurfaceRays raysOf(const storage::SurfaceMesh& mesh) {
    return render::SurfaceRays(mesh.positions, mesh.triangles);
}

}  // namespace

render::StippleSurface ballSurface(std::uint32_t points) {
    storage::SurfaceMesh mesh;
    addBall(mesh, 1.0);
    const auto positions = ballPoints(points);
    return {render::StippleReplay(hierarchyOf(positions, positions)), raysOf(mesh),
            Bounds{glm::dvec3(-1.0), glm::dvec3(1.0)}, 4.0 * pi};
}

render::StippleSurface floorSurface(std::uint32_t points) {
    storage::SurfaceMesh mesh;
    addBall(mesh, 0.5);
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const auto& [x, z] : {std::pair(-2, -2), std::pair(2, -2), std::pair(2, 2), std::pair(-2, 2)})
        mesh.positions.emplace_back(x, -1, z);
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first, first + 2, first + 3});
    std::vector<glm::vec3> positions;
    for (std::uint32_t i = 0; i < points; ++i) {
        const double turn = i * std::numbers::phi;
        positions.emplace_back(4.0 * spread(i + 1) - 2.0, -1.0, 4.0 * (turn - std::floor(turn)) - 2.0);
    }
    const std::vector<glm::vec3> up(points, glm::vec3(0.0F, 1.0F, 0.0F));
    return {render::StippleReplay(hierarchyOf(positions, up)), raysOf(mesh),
            Bounds{glm::dvec3(-2.0, -1.0, -2.0), glm::dvec3(2.0, 0.5, 2.0)}, 16.0};
}

namespace {

storage::SurfaceMesh ballMesh() {
    storage::SurfaceMesh mesh;
    addBall(mesh, 1.0);
    for (const auto& position : mesh.positions) mesh.normals.push_back(glm::normalize(position));
    mesh.edges = edgesOf(mesh);
    return mesh;
}

proto::Manifest ballManifest(const char* kind, const storage::SurfaceMesh& mesh) {
    proto::Manifest manifest;
    manifest.set_kind(kind);
    manifest.set_format(1);
    *manifest.mutable_mesh() = storage::describeMesh(mesh);
    return manifest;
}

storage::DatasetWriter writerTo(const std::filesystem::path& output) {
    auto writer = storage::DatasetWriter::create(output);
    if (!writer.ok()) throw storage::StorageError(writer.error());
    return *std::move(writer);
}

}  // namespace

void writeBall(const std::filesystem::path& output, std::uint32_t points) {
    const auto mesh = ballMesh();
    const auto positions = ballPoints(points);
    auto manifest = ballManifest("stipple", mesh);
    auto& stipple = *manifest.mutable_stipple();
    stipple.set_domain(proto::StippleManifest::SURFACE);
    stipple.set_points(points);
    stipple.set_locked(points);
    stipple.set_area(4.0 * pi);
    stipple.set_rings(1);
    stipple.set_relaxation(1.0);
    auto writer = writerTo(output);
    require(storage::writeHierarchy(writer.directory(), hierarchyOf(positions, positions)));
    require(storage::writeMesh(writer.directory(), mesh));
    for (const char* file : {"hierarchy.h5", "hierarchy.digest", "mesh.h5", "mesh.digest"})
        require(writer.add(file));
    require(writer.publish(manifest));
}

void writeBallMesh(const std::filesystem::path& output) {
    const auto mesh = ballMesh();
    auto writer = writerTo(output);
    require(storage::writeMesh(writer.directory(), mesh));
    for (const char* file : {"mesh.h5", "mesh.digest"}) require(writer.add(file));
    require(writer.publish(ballManifest("mesh", mesh)));
}

}  // namespace mote::test
