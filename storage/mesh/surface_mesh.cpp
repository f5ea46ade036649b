// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/mesh/surface_mesh.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "storage/places.h"

namespace mote::storage {
namespace {

bool edgeFits(const MeshEdge& edge, std::size_t vertices, std::size_t triangles) {
    const auto [first, second] = edge.triangles;
    return edge.vertices[0] < vertices && edge.vertices[1] < vertices && first < triangles &&
           (second < triangles || second == MeshEdge::none);
}

/// So no number is left out, and there are no more than triangles.
bool partsAreInOrder(const std::vector<std::uint32_t>& parts) {
    std::uint32_t count = 0;
    return std::all_of(parts.begin(), parts.end(), [&](std::uint32_t part) {
        if (part == count) ++count;
        return part < count;
    });
}

}  // namespace

Status checkSurfaceMesh(const SurfaceMesh& mesh) {
    const auto vertices = mesh.positions.size();
    if (mesh.normals.size() != vertices) return corrupt("/mesh/normal", "has not one for each vertex");
    if (!std::all_of(mesh.positions.begin(), mesh.positions.end(), isPlace)) {
        return corrupt("/mesh/position", "has one with a coordinate that is not finite or beyond 1e18");
    }
    // The length of a unit vector in three floats is off by less than 2^-22.
    if (!std::all_of(mesh.normals.begin(), mesh.normals.end(),
                     [](const auto& normal) { return std::abs(glm::length(normal) - 1.0F) < 1e-5F; })) {
        return corrupt("/mesh/normal", "has one that is not of unit length");
    }
    for (const auto& triangle : mesh.triangles) {
        if (std::any_of(triangle.begin(), triangle.end(), [&](auto v) { return v >= vertices; })) {
            return corrupt("/mesh/triangle", "names a vertex that there is not");
        }
    }
    for (const auto& edge : mesh.edges) {
        if (!edgeFits(edge, vertices, mesh.triangles.size())) {
            return corrupt("/mesh/edge", "names a vertex or triangle that there is not");
        }
    }
    if (vertices + 2 * mesh.intersections.size() > std::numeric_limits<std::uint32_t>::max()) {
        return corrupt("/mesh/intersection", "has more pairs than can be counted");
    }
    for (const auto& [one, other] : mesh.intersections) {
        if (std::max(one, other) >= mesh.triangles.size())
            return corrupt("/mesh/intersection", "names a triangle that there is not");
    }
    if (!mesh.parts.empty() && mesh.parts.size() != mesh.triangles.size()) {
        return corrupt("/mesh/part", "has not one for each triangle");
    }
    if (!partsAreInOrder(mesh.parts)) {
        return corrupt("/mesh/part", "has a part whose number is not next in the order of first triangles");
    }
    return success();
}

}  // namespace mote::storage
