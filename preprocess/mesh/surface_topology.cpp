// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/mesh/surface_topology.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <numeric>
#include <tuple>

namespace mote::prep {
namespace {

using storage::MeshEdge;

const double leastSmooth = std::cos(40.0 * 3.14159265358979323846 / 180.0);

glm::dvec3 edgeVector(const TriangleMesh& mesh, const Triangle& triangle, std::uint32_t from,
                      std::uint32_t to) {
    return glm::dvec3(mesh.positions[triangle[to % 3]]) - glm::dvec3(mesh.positions[triangle[from % 3]]);
}

/// Welding has left no triangle without one.
glm::dvec3 normalOf(const TriangleMesh& mesh, const Triangle& triangle) {
    return glm::normalize(
        glm::cross(glm::normalize(edgeVector(mesh, triangle, 0, 1)), edgeVector(mesh, triangle, 0, 2)));
}

double angleAt(const TriangleMesh& mesh, const Triangle& triangle, std::uint32_t corner) {
    const auto a = glm::normalize(edgeVector(mesh, triangle, corner, corner + 1));
    const auto b = glm::normalize(edgeVector(mesh, triangle, corner, corner + 2));
    return std::acos(std::clamp(glm::dot(a, b), -1.0, 1.0));
}

/// Corners of triangles, three each, joined where they share a vertex of the dataset.
class Corners {
  public:
    explicit Corners(std::size_t triangles) : parent_(3 * triangles) {
        std::iota(parent_.begin(), parent_.end(), 0U);
    }
    std::uint32_t root(std::uint32_t corner) {
        while (parent_[corner] != corner) corner = parent_[corner] = parent_[parent_[corner]];
        return corner;
    }
    void join(std::uint32_t a, std::uint32_t b) {
        const auto first = root(a);
        const auto second = root(b);
        parent_[std::max(first, second)] = std::min(first, second);
    }

  private:
    std::vector<std::uint32_t> parent_;
};

/// The corner of `triangle` at a welded vertex.
std::uint32_t cornerAt(const Triangle& triangle, std::uint32_t vertex) {
    return static_cast<std::uint32_t>(std::find(triangle.begin(), triangle.end(), vertex) - triangle.begin());
}

Corners joinSmooth(const TriangleMesh& mesh, const TriangleNeighbours& neighbours,
                   const std::vector<glm::dvec3>& normals) {
    Corners corners(mesh.triangles.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        for (std::uint32_t i = 0; i < 3; ++i) {
            const auto other = neighbours[t][i];
            if (other == MeshEdge::none || other < t || glm::dot(normals[t], normals[other]) < leastSmooth)
                continue;
            for (const auto end : {i, (i + 1) % 3}) {
                corners.join(3 * t + end,
                             3 * other + cornerAt(mesh.triangles[other], mesh.triangles[t][end]));
            }
        }
    }
    return corners;
}

/// Triangles around a vertex may sum up to nothing: then it has the normal of one of them.
void keepNormalsFinite(const std::vector<glm::dvec3>& normals, storage::SurfaceMesh& made) {
    for (std::size_t t = 0; t < made.triangles.size(); ++t) {
        for (const auto vertex : made.triangles[t]) {
            auto& normal = made.normals[vertex];
            if (!(std::abs(glm::length(normal) - 1.0F) < 1e-6F)) normal = glm::vec3(normals[t]);
        }
    }
}

/// Parts numbered in the order of their first triangles; empty where there is but one.
std::vector<std::uint32_t> numberedParts(const std::vector<std::uint32_t>& parts) {
    std::map<std::uint32_t, std::uint32_t> numbers;
    std::vector<std::uint32_t> made;
    made.reserve(parts.size());
    for (const auto part : parts)
        made.push_back(numbers.try_emplace(part, static_cast<std::uint32_t>(numbers.size())).first->second);
    if (numbers.size() < 2) made.clear();
    return made;
}

}  // namespace

TriangleNeighbours neighboursOf(const storage::SurfaceMesh& mesh) {
    TriangleNeighbours neighbours(mesh.triangles.size(), {MeshEdge::none, MeshEdge::none, MeshEdge::none});
    const auto place = [&](std::uint32_t triangle, std::uint32_t corner) {
        return mesh.positions[mesh.triangles[triangle][corner % 3]];
    };
    for (const auto& edge : mesh.edges) {
        if (edge.triangles[1] == MeshEdge::none) continue;
        const auto a = mesh.positions[edge.vertices[0]];
        const auto b = mesh.positions[edge.vertices[1]];
        for (const int at : {0, 1}) {
            const auto t = edge.triangles[at];
            for (std::uint32_t i = 0; i < 3; ++i) {
                const bool along = place(t, i) == a && place(t, i + 1) == b;
                const bool against = place(t, i) == b && place(t, i + 1) == a;
                if (along || against) neighbours[t][i] = edge.triangles[1 - at];
            }
        }
    }
    return neighbours;
}

storage::SurfaceMesh makeSurfaceMesh(const TriangleMesh& mesh) {
    const auto neighbours = findNeighbours(mesh.triangles);
    std::vector<glm::dvec3> normals;
    normals.reserve(mesh.triangles.size());
    for (const auto& triangle : mesh.triangles) normals.push_back(normalOf(mesh, triangle));
    auto corners = joinSmooth(mesh, neighbours, normals);
    storage::SurfaceMesh made;
    made.triangles.resize(mesh.triangles.size());
    std::vector<std::uint32_t> vertexOf(3 * mesh.triangles.size());
    std::vector<glm::dvec3> sums;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        for (std::uint32_t i = 0; i < 3; ++i) {
            const auto corner = 3 * t + i;
            const auto root = corners.root(corner);
            if (root == corner) {
                vertexOf[corner] = static_cast<std::uint32_t>(made.positions.size());
                made.positions.push_back(mesh.positions[mesh.triangles[t][i]]);
                sums.emplace_back(0.0);
            }
            made.triangles[t][i] = vertexOf[root];
            sums[vertexOf[root]] += normals[t] * angleAt(mesh, mesh.triangles[t], i);
        }
    }
    made.normals.reserve(sums.size());
    for (const auto& sum : sums) made.normals.emplace_back(glm::normalize(sum));
    keepNormalsFinite(normals, made);
    made.edges = storage::edgesOf(made.triangles, neighbours);
    made.parts = numberedParts(mesh.parts);
    return made;
}

}  // namespace mote::prep
