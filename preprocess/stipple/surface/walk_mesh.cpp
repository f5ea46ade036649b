// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/stipple/surface/walk_mesh.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

namespace mote::prep {
namespace {

constexpr int mostTriangles = 10000;

/// What a way out of a triangle is.
struct Exit {
    std::uint32_t side;
    double share;  ///< of the step, until there
};

using Corners = std::array<glm::dvec3, 3>;

/// The side through which a step leaves, not the one that it entered by. A step along a side leaves it there.
std::optional<Exit> findExit(const Corners& corners, const glm::dvec3& normal, const glm::dvec3& from,
                             const glm::dvec3& step, std::uint32_t entered) {
    std::optional<Exit> exit;
    for (std::uint32_t side = 0; side < 3; ++side) {
        if (side == entered) continue;
        const auto& a = corners[side];
        const auto inward = glm::cross(normal, corners[(side + 1) % 3] - a);
        const double speed = glm::dot(step, inward);
        if (speed >= 0.0) continue;
        const double share = std::max(glm::dot(a - from, inward) / speed, 0.0);
        if (share < 1.0 && (!exit || share < exit->share)) exit = Exit{side, share};
    }
    return exit;
}

/// `vector` turned into the plane of this normal, its length kept.
glm::dvec3 turnedInto(const glm::dvec3& vector, const glm::dvec3& normal) {
    const auto flat = vector - glm::dot(vector, normal) * normal;
    const double length = glm::length(flat);
    return length > 0.0 ? flat * (glm::length(vector) / length) : glm::dvec3(0.0);
}

}  // namespace

WalkMesh::WalkMesh(const storage::SurfaceMesh& mesh, const TriangleNeighbours& neighbours) : mesh_(mesh) {
    const auto count = mesh.triangles.size();
    facets_.reserve(count);
    areas_.reserve(count);
    for (std::uint32_t t = 0; t < count; ++t) {
        const auto a = corner(t, 0);
        const auto b = corner(t, 1);
        const auto c = corner(t, 2);
        const auto cross = glm::cross(b - a, c - a);
        const auto center = (a + b + c) / 3.0;
        const double radius =
            std::max({glm::distance(center, a), glm::distance(center, b), glm::distance(center, c)});
        // A little more, for the centre and the radius are rounded.
        facets_.push_back({glm::vec3(glm::normalize(cross)), glm::vec3(center),
                           static_cast<float>(1.0001 * radius), neighbours[t]});
        areas_.push_back(0.5 * glm::length(cross));
        area_ += areas_.back();
    }
    for (auto& facet : facets_) {
        for (auto& other : facet.neighbours) {
            const bool border = other != none && glm::dot(facet.normal, facets_[other].normal) < borderCosine;
            if (border) other = none;
        }
    }
}

glm::dvec3 WalkMesh::normalAt(const SurfacePoint& point) const {
    const auto t = point.triangle;
    const glm::dvec3 face(facets_[t].normal);
    glm::dvec3 sum(0.0);
    for (std::uint32_t i = 0; i < 3; ++i) {
        const auto a = corner(t, (i + 1) % 3);
        const auto b = corner(t, (i + 2) % 3);
        const double weight = glm::dot(glm::cross(a - point.position, b - point.position), face);
        sum += std::max(weight, 0.0) * glm::dvec3(mesh_.normals[mesh_.triangles[t][i]]);
    }
    const double length = glm::length(sum);
    return length > 0.0 ? sum / length : face;
}

SurfacePoint WalkMesh::walk(SurfacePoint point, const glm::dvec3& wanted) const {
    auto step = turnedInto(wanted, glm::dvec3(facets_[point.triangle].normal));
    std::uint32_t entered = 3;
    for (int i = 0; i < mostTriangles; ++i) {
        const Corners corners{corner(point.triangle, 0), corner(point.triangle, 1),
                              corner(point.triangle, 2)};
        const auto exit =
            findExit(corners, glm::dvec3(facets_[point.triangle].normal), point.position, step, entered);
        if (!exit) {
            point.position += step;
            return point;
        }
        point.position += exit->share * step;
        const auto next = facets_[point.triangle].neighbours[exit->side];
        if (next == none) return point;
        const auto& back = facets_[next].neighbours;
        entered =
            static_cast<std::uint32_t>(std::find(back.begin(), back.end(), point.triangle) - back.begin());
        // Unfolded around the edge: what goes along it stays, what goes across it turns into the next plane.
        const auto edge = glm::normalize(corners[(exit->side + 1) % 3] - corners[exit->side]);
        const double along = glm::dot(step, edge);
        const double across = std::sqrt(std::max(glm::dot(step, step) - along * along, 0.0));
        const auto opposite = corner(next, (entered + 2) % 3) - point.position;
        const auto inward = opposite - glm::dot(opposite, edge) * edge;
        step = (1.0 - exit->share) * (along * edge + across * glm::normalize(inward));
        point.triangle = next;
    }
    return point;
}

}  // namespace mote::prep
