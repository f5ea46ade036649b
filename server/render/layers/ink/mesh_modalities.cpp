// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/mesh_modalities.h"

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "protocol/scene/srgb.h"
#include "protocol/scene/write_fields.h"
#include "server/render/ink/complexity.h"
#include "server/render/layers/mesh/mesh_sight.h"
#include "server/render/layers/mesh/mesh_surface.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

/// Tells how much of the light that comes from all sides a mesh's own surroundings keep away from places of
/// it (Zhukov and others 1998, An ambient light illumination model). Refers to the surface; any number of
/// threads.
class AmbientOcclusion {
  public:
    /// Sides of the square of pixels that together look in all directions.
    static constexpr std::uint32_t tile = 4;

    /// `rays`: of a pixel; a tile's pixels each take others.
    AmbientOcclusion(const MeshSurface& surface, std::uint32_t rays);

    /// The share of a pixel's rays, spread as a matt surface takes light, that meet something near, where a
    /// ray sees the mesh: 0 to 1.
    double at(const MeshRay& seen, const MeshMeeting& met, std::uint32_t column, std::uint32_t row) const;

  private:
    const MeshSurface& surface_;
    std::uint32_t rays_;
    double gap_, reach_;                  // of rays, layer space
    std::vector<glm::dvec3> directions_;  // [place in the tile][ray], about the z axis, unit
};

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

constexpr std::uint32_t mostPlaces = 4;
constexpr std::array<std::array<double, 2>, mostPlaces> places{
    {{-0.125, -0.375}, {0.375, -0.125}, {-0.375, 0.125}, {0.125, 0.375}}};
// Below this share of its length a normal that is seen points at the eye.
constexpr double leastAcross = 1e-3;
// Rays of a pixel that look for what keeps light from all sides away, at rest and in motion.
constexpr std::uint32_t exactOcclusion = 4, quickOcclusion = 1;

/// Whether a drawing asks for tones: else one place a pixel tells all that is needed of it.
bool needsTone(const InkStyle& style) {
    const auto& lines = style.silhouettes;
    return style.show != InkPicture::drawing || lines.mode == SilhouetteMode::adjusted || lines.omit ||
           style.hatch.strength > 0.0 || style.solid.strength > 0.0 || style.wash.everywhere ||
           !style.regions.empty();
}

MeshStyle white(const InkStyle& style) {
    MeshStyle mesh;
    writeColor(glm::dvec3(1.0), mesh.mutable_color());
    *mesh.mutable_light() = toProto(style.light);
    return mesh;
}

/// Parts of rows of a mesh's modalities, one thread's.
class RowMaker {
  public:
    /// `closed`: the share of light from all sides that is kept away; or empty.
    RowMaker(const MeshSight& sight, const MeshSurface& surface, const AmbientOcclusion& occlusion,
             float paper, std::uint32_t samples, MeshModalities& made, Raster<float>& closed)
        : sight_(sight),
          mesh_(surface.rays()),
          parts_(surface.mesh().parts),
          occlusion_(occlusion),
          paper_(paper),
          samples_(samples),
          made_(made.modalities),
          triangle_(made.triangle),
          farthest_(made.farthest),
          closed_(closed) {}

    void make(std::uint32_t row, std::uint32_t from, std::uint32_t to) {
        const std::uint32_t step = MeshRays::packet / samples_;
        for (std::uint32_t column = from; column < to; column += step) {
            const std::uint32_t count = std::min(step, to - column);
            look(column, count, row);
            for (std::uint32_t i = 0; i < count; ++i) take(column + i, row, i * samples_);
        }
    }

  private:
    void look(std::uint32_t column, std::uint32_t count, std::uint32_t row) {
        for (std::uint32_t i = 0; i < MeshRays::packet; ++i) {
            inLayer_[i] = {};
            if (i >= count * samples_) continue;
            const auto [x, y] = samples_ == 1 ? std::array{0.0, 0.0} : places[i % samples_];
            const std::uint32_t pixel = column + i / samples_;
            rays_[i] = sight_.through(pixel + 0.5 + x, row + 0.5 + y);
            inLayer_[i] = rays_[i].inLayer;
        }
        mesh_.first(inLayer_, met_);
    }
    void take(std::uint32_t column, std::uint32_t row, std::uint32_t first) {
        double grey = 0.0;
        double farthest = 0.0;
        std::uint32_t nearest = first, hits = 0;
        auto& depth = made_.depth.at(column, row);
        for (std::uint32_t i = first; i < first + samples_; ++i) {
            const bool any = met_[i].triangle != MeshMeeting::none;
            const auto hit = any ? sight_.hit(rays_[i], met_[i]) : std::nullopt;
            hits += hit ? 1U : 0U;
            farthest = std::max(farthest, hit ? hit->depth : HUGE_VAL);
            grey += hit ? std::min(luminance(hit->color), 1.0) : paper_;
            if (!hit || static_cast<float>(hit->depth) >= depth) continue;
            depth = static_cast<float>(hit->depth);
            nearest = i;
            const glm::dvec2 across(hit->normal.x, -hit->normal.y);
            const double sine = glm::length(across);
            made_.angle.at(column, row) = sine > leastAcross ? angleOf(across) : 0.0F;
            made_.across.at(column, row) = static_cast<float>(std::copysign(sine, hit->normal.z));
            made_.part.at(column, row) = parts_.empty() ? 0U : parts_[met_[i].triangle];
            triangle_.at(column, row) = met_[i].triangle;
        }
        made_.grey.at(column, row) = static_cast<float>(grey / samples_);
        farthest_.at(column, row) = static_cast<float>(farthest);
        if (closed_.values.empty() || hits == 0) return;
        const double closed = occlusion_.at(inLayer_[nearest], met_[nearest], column, row);
        closed_.at(column, row) = static_cast<float>(closed * hits / samples_);
    }

    const MeshSight& sight_;
    const MeshRays& mesh_;
    const std::vector<std::uint32_t>& parts_;
    const AmbientOcclusion& occlusion_;
    const float paper_;
    const std::uint32_t samples_;
    Modalities& made_;
    Raster<std::uint32_t>& triangle_;
    Raster<float>& farthest_;
    Raster<float>& closed_;
    std::array<SightRay, MeshRays::packet> rays_;
    std::array<MeshRay, MeshRays::packet> inLayer_;
    std::array<MeshMeeting, MeshRays::packet> met_;
};

/// Takes from the grey what of the ambient light is kept away. Each pixel has looked in few directions: its
/// neighbours on the surface have looked in the others.
void darken(Modalities& modalities, const Raster<float>& closed, const InkStyle& style) {
    const auto even =
        blurredWithin(closed, modalities.depth, modalities.extent, 0.5 * AmbientOcclusion::tile);
    const auto most = static_cast<float>(std::min(1.0, style.light.ambient) * style.occlusion);
    for (std::size_t i = 0; i < even.values.size(); ++i) {
        if (!std::isfinite(modalities.depth.values[i])) continue;
        auto& grey = modalities.grey.values[i];
        grey = std::max(0.0F, grey - most * even.values[i]);
    }
}

}  // namespace

MeshModalities modalitiesOf(const MeshSurface& surface, const glm::dmat4& transform, const InkStyle& style,
                            const FramePlan& plan, const std::stop_token& stop) {
    const float paper = style.inkIsDark ? 1.0F : 0.0F;
    const std::uint32_t width = plan.width, height = plan.height;
    // One after the other: g++ 12 frees what is in inner braces twice if what follows them throws.
    MeshModalities made;
    made.modalities.grey = Raster<float>(width, height, paper);
    made.modalities.depth = Raster<float>(width, height, HUGE_VALF);
    made.modalities.angle = Raster<float>(width, height);
    made.modalities.part = Raster<std::uint32_t>(width, height, Modalities::nothing);
    made.modalities.across = Raster<float>(width, height);
    made.triangle = Raster<std::uint32_t>(width, height, MeshMeeting::none);
    made.farthest = Raster<float>(width, height, HUGE_VALF);
    const MeshStyle mesh = white(style);
    const MeshSight sight(plan, transform, mesh, surface, 1.0);
    made.modalities.extent = std::max(sight.farDepth() - sight.nearDepth(), 1e-300);
    const std::uint32_t samples = plan.exact && needsTone(style) ? mostPlaces : 1;
    const AmbientOcclusion occlusion(surface, plan.exact ? exactOcclusion : quickOcclusion);
    Raster<float> closed;
    if (style.occlusion > 0.0) closed = Raster<float>(width, height);
    forPixelsInTurns(width, height, [&](std::uint32_t row, std::uint32_t from, std::uint32_t to) {
        if (isStopped(stop)) return;
        RowMaker(sight, surface, occlusion, paper, samples, made, closed).make(row, from, to);
    });
    if (!closed.values.empty() && !isStopped(stop)) darken(made.modalities, closed, style);
    return made;
}

std::optional<double> depthAt(const MeshSurface& surface, const glm::dmat4& transform, const InkStyle& style,
                              const FramePlan& plan, glm::dvec2 at) {
    const MeshStyle mesh = white(style);
    const MeshSight sight(plan, transform, mesh, surface, 1.0);
    std::array<MeshRay, MeshRays::packet> rays{};
    std::array<MeshMeeting, MeshRays::packet> met;
    const auto ray = sight.through(at.x, at.y);
    rays[0] = ray.inLayer;
    surface.rays().first(rays, met);
    if (met[0].triangle == MeshMeeting::none) return std::nullopt;
    const auto hit = sight.hit(ray, met[0]);
    return hit ? std::optional(hit->depth) : std::nullopt;
}

}  // namespace mote::render
