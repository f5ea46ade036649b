// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/mesh/weld_mesh.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>
#include <tuple>

#include "storage/places.h"

namespace mote::prep {
namespace {

constexpr std::uint32_t noVertex = std::numeric_limits<std::uint32_t>::max();
constexpr double leastHeight = 1e-7;   // of the longest edge
constexpr double needleHeight = 1e-3;  // of the longest edge

/// The first vertex at each vertex's place; none where it is no place.
std::vector<std::uint32_t> firstAtPlace(const std::vector<glm::vec3>& positions) {
    std::vector<std::uint32_t> order;
    order.reserve(positions.size());
    for (std::uint32_t i = 0; i < positions.size(); ++i) {
        if (storage::isPlace(positions[i])) order.push_back(i);
    }
    const auto place = [&](std::uint32_t i) {
        return std::tuple(positions[i].x, positions[i].y, positions[i].z);
    };
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return std::tuple(place(a), a) < std::tuple(place(b), b);
    });
    std::vector<std::uint32_t> first(positions.size(), noVertex);
    for (std::size_t i = 0; i < order.size(); ++i) {
        const bool again = i > 0 && place(order[i]) == place(order[i - 1]);
        first[order[i]] = again ? first[order[i - 1]] : order[i];
    }
    return first;
}

/// Height over the longest edge; 0 where that has no length.
double heightOf(const TriangleMesh& mesh, const Triangle& triangle) {
    const glm::dvec3 a(mesh.positions[triangle[0]]);
    const glm::dvec3 b(mesh.positions[triangle[1]]);
    const glm::dvec3 c(mesh.positions[triangle[2]]);
    const double longest = std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
    if (!(longest > 0.0)) return 0.0;
    const double height = glm::length(glm::cross((b - a) / longest, (c - a) / longest));
    return std::isfinite(height) ? height : 0.0;
}

Triangle sorted(Triangle triangle) {
    std::sort(triangle.begin(), triangle.end());
    return triangle;
}

/// Moves triangle `from`, with its part, to the place of one that is left out.
void keep(TriangleMesh& mesh, std::size_t from, std::size_t to) {
    mesh.triangles[to] = mesh.triangles[from];
    if (!mesh.parts.empty()) mesh.parts[to] = mesh.parts[from];
}

void keepFirst(TriangleMesh& mesh, std::size_t count) {
    mesh.triangles.resize(count);
    if (!mesh.parts.empty()) mesh.parts.resize(count);
}

void removeRepeated(TriangleMesh& mesh, MeshCounts& counts) {
    const auto& triangles = mesh.triangles;
    std::vector<std::uint32_t> order(triangles.size());
    std::iota(order.begin(), order.end(), 0U);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return std::tuple(sorted(triangles[a]), a) < std::tuple(sorted(triangles[b]), b);
    });
    std::vector<bool> repeated(triangles.size());
    for (std::size_t i = 1; i < order.size(); ++i) {
        repeated[order[i]] = sorted(triangles[order[i]]) == sorted(triangles[order[i - 1]]);
    }
    std::size_t kept = 0;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        if (!repeated[i]) keep(mesh, i, kept++);
    }
    counts.repeated += triangles.size() - kept;
    keepFirst(mesh, kept);
}

void removeUnused(TriangleMesh& mesh) {
    std::vector<std::uint32_t> renamed(mesh.positions.size(), noVertex);
    for (const auto& triangle : mesh.triangles) {
        for (const auto corner : triangle) renamed[corner] = 0;
    }
    std::uint32_t kept = 0;
    for (std::size_t i = 0; i < renamed.size(); ++i) {
        if (renamed[i] == noVertex) continue;
        mesh.positions[kept] = mesh.positions[i];
        renamed[i] = kept++;
    }
    mesh.positions.resize(kept);
    for (auto& triangle : mesh.triangles) {
        for (auto& corner : triangle) corner = renamed[corner];
    }
}

}  // namespace

TriangleMesh weldMesh(TriangleMesh mesh, MeshCounts& counts) {
    counts.vertices += mesh.positions.size();
    counts.triangles += mesh.triangles.size();
    counts.smallFaces += mesh.smallFaces;
    counts.tangled += mesh.tangled;
    const auto first = firstAtPlace(mesh.positions);
    std::uint64_t placed = 0;
    for (std::uint32_t i = 0; i < first.size(); ++i) placed += first[i] == i || first[i] == noVertex ? 1 : 0;
    counts.duplicates += mesh.positions.size() - placed;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        auto& triangle = mesh.triangles[i];
        for (auto& corner : triangle) corner = first[corner];
        if (std::find(triangle.begin(), triangle.end(), noVertex) != triangle.end()) {
            ++counts.notFinite;
            continue;
        }
        const double height = heightOf(mesh, triangle);
        if (height < leastHeight) {
            ++counts.degenerate;
            continue;
        }
        if (height < needleHeight) ++counts.needles;
        keep(mesh, i, kept++);
    }
    keepFirst(mesh, kept);
    removeRepeated(mesh, counts);
    removeUnused(mesh);
    counts.unused += placed - mesh.positions.size();
    return mesh;
}

}  // namespace mote::prep
