// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/ambient_occlusion.h"

#include <array>
#include <cmath>
#include <glm/geometric.hpp>

namespace mote::render {
namespace {

// Of the bounds' diagonal: rays start so far off the surface, as those towards a light do, and what lies
// farther off than the reach keeps no light away: else a room would be black.
constexpr double gapShare = 1e-4, reachShare = 0.2;
// The golden angle's cosine and sine.
constexpr glm::dvec2 goldenTurn{-0.73736887807831963, 0.67549029426152362};
// Pixels of a tile in an order in which those that follow one another lie apart.
constexpr std::array<std::uint32_t, 16> order{0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5};
static_assert(order.size() == std::size_t{AmbientOcclusion::tile} * AmbientOcclusion::tile);

/// Unit vectors about z whose places on the plane below them are even on a disc (Vogel's spiral): the share
/// of them in a direction goes with its cosine.
std::vector<glm::dvec3> spread(std::size_t count) {
    std::vector<glm::dvec3> made;
    glm::dvec2 turn(1.0, 0.0);
    for (std::size_t i = 0; i < count; ++i) {
        const double square = (static_cast<double>(i) + 0.5) / static_cast<double>(count);
        made.emplace_back(std::sqrt(square) * turn, std::sqrt(1.0 - square));
        turn = {turn.x * goldenTurn.x - turn.y * goldenTurn.y, turn.x * goldenTurn.y + turn.y * goldenTurn.x};
    }
    return made;
}

struct Basis {
    glm::dvec3 x, y, z;

    /// Around a unit vector (Duff and others 2017, Building an Orthonormal Basis, Revisited).
    explicit Basis(const glm::dvec3& normal) : z(normal) {
        const double sign = normal.z < 0.0 ? -1.0 : 1.0;
        const double a = -1.0 / (sign + normal.z), b = normal.x * normal.y * a;
        x = {1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x};
        y = {b, sign + normal.y * normal.y * a, -normal.y};
    }
    glm::dvec3 operator()(const glm::dvec3& local) const { return local.x * x + local.y * y + local.z * z; }
};

}  // namespace

AmbientOcclusion::AmbientOcclusion(const MeshSurface& surface, std::uint32_t rays)
    : surface_(surface),
      rays_(rays),
      gap_(gapShare * glm::length(surface.bounds().size())),
      reach_(reachShare * glm::length(surface.bounds().size())) {
    const auto all = spread(order.size() * rays);
    for (const auto place : order) {
        for (std::uint32_t i = 0; i < rays; ++i) directions_.push_back(all[place + order.size() * i]);
    }
}

double AmbientOcclusion::at(const MeshRay& seen, const MeshMeeting& met, std::uint32_t column,
                            std::uint32_t row) const {
    const auto& mesh = surface_.mesh();
    const auto [i, j, k] = mesh.triangles[met.triangle];
    const glm::dvec3 a(mesh.positions[i]);
    const glm::dvec3 area = glm::cross(glm::dvec3(mesh.positions[j]) - a, glm::dvec3(mesh.positions[k]) - a);
    const double side = glm::dot(area, seen.direction) > 0.0 ? -1.0 : 1.0;
    const glm::dvec3 flat = side * glm::normalize(area);
    const glm::dvec3 smooth =
        side * (met.weights.x * glm::dvec3(mesh.normals[i]) + met.weights.y * glm::dvec3(mesh.normals[j]) +
                met.weights.z * glm::dvec3(mesh.normals[k]));
    const Basis basis(glm::dot(smooth, smooth) > 0.0 ? glm::normalize(smooth) : flat);
    const glm::dvec3 from = seen.origin + met.at * seen.direction + gap_ * flat;
    const std::size_t first = std::size_t{rays_} * ((row % tile) * tile + column % tile);
    std::uint32_t blocked = 0;
    for (std::size_t n = first; n < first + rays_; ++n) {
        glm::dvec3 way = basis(directions_[n]);
        // A smoothed normal leans: what goes into the triangle is turned back out.
        const double out = glm::dot(way, flat);
        if (out < 0.0) way -= 2.0 * out * flat;
        MeshRay ray{from, way, 0.0, reach_};
        ray.clip(surface_.rays().box());
        blocked += surface_.rays().blocked(ray) ? 1U : 0U;
    }
    return static_cast<double>(blocked) / rays_;
}

}  // namespace mote::render
