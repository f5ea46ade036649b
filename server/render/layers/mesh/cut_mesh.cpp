// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/mesh/cut_mesh.h"

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

#include "storage/mesh/triangle_neighbours.h"

namespace mote::render {
namespace {

using Corners = std::array<std::uint32_t, 3>;

bool liesBefore(const glm::vec3& a, const glm::vec3& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

/// Cuts a mesh by one half-space.
class MeshCut {
  public:
    MeshCut(const storage::SurfaceMesh& mesh, const HalfSpace& side) : mesh_(mesh) {
        for (const auto& place : mesh.positions) heights_.push_back(side.within(glm::dvec3(place)));
        kept_.assign(mesh.positions.size(), missing);
    }

    storage::SurfaceMesh cut() {
        std::vector<std::array<std::uint32_t, 2>>
            become;  // of each triangle, from the first to behind the last
        for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
            const auto before = static_cast<std::uint32_t>(made_.triangles.size());
            add(t);
            become.push_back({before, static_cast<std::uint32_t>(made_.triangles.size())});
        }
        for (const auto& pair : mesh_.intersections) {
            for (auto a = become[pair[0]][0]; a < become[pair[0]][1]; ++a) {
                for (auto b = become[pair[1]][0]; b < become[pair[1]][1]; ++b)
                    made_.intersections.push_back({a, b});
            }
        }
        return std::move(made_);
    }

  private:
    static constexpr std::uint32_t missing = UINT32_MAX;

    std::uint32_t put(const glm::vec3& place, const glm::vec3& normal) {
        made_.positions.push_back(place);
        made_.normals.push_back(normal);
        return static_cast<std::uint32_t>(made_.positions.size() - 1);
    }
    std::uint32_t keep(std::uint32_t vertex) {
        auto& number = kept_[vertex];
        if (number == missing) number = put(mesh_.positions[vertex], mesh_.normals[vertex]);
        return number;
    }
    /// Where an edge goes through the side: the same place from whichever of its ends, of all vertices there.
    std::uint32_t between(std::uint32_t a, std::uint32_t b) {
        if (liesBefore(mesh_.positions[b], mesh_.positions[a])) std::swap(a, b);
        const auto [known, fresh] = crossings_.try_emplace({a, b}, missing);
        if (!fresh) return known->second;
        const double share = heights_[a] / (heights_[a] - heights_[b]);
        const glm::dvec3 from(mesh_.positions[a]), to(mesh_.positions[b]);
        const glm::dvec3 normal = glm::mix(glm::dvec3(mesh_.normals[a]), glm::dvec3(mesh_.normals[b]), share);
        const bool turns = glm::length(normal) > 1e-6;
        return known->second = put(glm::vec3(glm::mix(from, to, share)),
                                   turns ? glm::vec3(glm::normalize(normal)) : mesh_.normals[a]);
    }

    void add(std::uint32_t triangle) {
        std::vector<std::uint32_t> left;
        const Corners& corners = mesh_.triangles[triangle];
        for (std::size_t i = 0; i < 3; ++i) {
            const auto here = corners[i], next = corners[(i + 1) % 3];
            const bool inside = heights_[here] >= 0.0;
            if (inside) left.push_back(keep(here));
            if (inside != (heights_[next] >= 0.0)) left.push_back(between(here, next));
        }
        for (std::size_t i = 2; i < left.size(); ++i) addTriangle({left[0], left[i - 1], left[i]}, triangle);
    }
    void addTriangle(const Corners& corners, std::uint32_t from) {
        const auto& at = made_.positions;
        const auto [a, b, c] = corners;
        if (at[a] == at[b] || at[b] == at[c] || at[c] == at[a]) return;
        made_.triangles.push_back(corners);
        if (!mesh_.parts.empty()) made_.parts.push_back(mesh_.parts[from]);
    }

    const storage::SurfaceMesh& mesh_;
    std::vector<double> heights_;      // of vertices, within
    std::vector<std::uint32_t> kept_;  // by vertex
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> crossings_;
    storage::SurfaceMesh made_;
};

/// One place, one vertex.
storage::Triangles welded(const storage::SurfaceMesh& mesh) {
    std::vector<std::uint32_t> order(mesh.positions.size()), place(mesh.positions.size());
    std::iota(order.begin(), order.end(), 0U);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return liesBefore(mesh.positions[a], mesh.positions[b]);
    });
    for (std::size_t i = 0; i < order.size(); ++i) {
        const bool same = i > 0 && mesh.positions[order[i]] == mesh.positions[order[i - 1]];
        place[order[i]] = same ? place[order[i - 1]] : order[i];
    }
    auto triangles = mesh.triangles;
    for (auto& corners : triangles) {
        for (auto& corner : corners) corner = place[corner];
    }
    return triangles;
}

/// Numbered from 0 in the order of their first triangles.
void number(std::vector<std::uint32_t>& parts) {
    std::map<std::uint32_t, std::uint32_t> numbers;
    for (auto& part : parts)
        part = numbers.try_emplace(part, static_cast<std::uint32_t>(numbers.size())).first->second;
}

}  // namespace

storage::SurfaceMesh cutMesh(const storage::SurfaceMesh& mesh, const HalfSpaces& clips) {
    storage::SurfaceMesh made = mesh;
    for (const auto& side : clips) made = MeshCut(made, side).cut();
    made.edges = storage::edgesOf(made.triangles, storage::findNeighbours(welded(made)));
    number(made.parts);
    return made;
}

}  // namespace mote::render
