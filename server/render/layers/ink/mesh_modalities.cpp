// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/mesh_modalities.h"

#include <tbb/parallel_for.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "protocol/scene/srgb.h"
#include "server/render/layers/mesh/mesh_sight.h"

namespace mote::render {
namespace {

constexpr std::uint32_t mostPlaces = 4;
constexpr std::array<std::array<double, 2>, mostPlaces> places{
    {{-0.125, -0.375}, {0.375, -0.125}, {-0.375, 0.125}, {0.125, 0.375}}};
// Below this share of its length a normal that is seen points at the eye.
constexpr double leastAcross = 1e-3;

MeshStyle white(const InkStyle& style) {
    MeshStyle mesh;
    mesh.color = glm::dvec3(1.0);
    mesh.light = style.light;
    return mesh;
}

/// Rows of a mesh's modalities, one thread's.
class RowMaker {
  public:
    RowMaker(const MeshSight& sight, const MeshRays& rays, float paper, bool exact, MeshModalities& made)
        : sight_(sight),
          mesh_(rays),
          paper_(paper),
          samples_(exact ? mostPlaces : 1),
          made_(made.modalities),
          triangle_(made.triangle) {}

    void make(std::uint32_t row) {
        const std::uint32_t step = MeshRays::packet / samples_;
        for (std::uint32_t column = 0; column < made_.grey.width; column += step) {
            const std::uint32_t count = std::min(step, made_.grey.width - column);
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
        auto& depth = made_.depth.at(column, row);
        for (std::uint32_t i = first; i < first + samples_; ++i) {
            const bool any = met_[i].triangle != MeshMeeting::none;
            const auto hit = any ? sight_.hit(rays_[i], met_[i]) : std::nullopt;
            grey += hit ? std::min(luminance(hit->color), 1.0) : paper_;
            if (!hit || static_cast<float>(hit->depth) >= depth) continue;
            depth = static_cast<float>(hit->depth);
            const glm::dvec2 across(hit->normal.x, -hit->normal.y);
            made_.angle.at(column, row) =
                glm::length(across) > leastAcross ? static_cast<float>(std::atan2(across.y, across.x)) : 0.0F;
            made_.part.at(column, row) = 0;
            triangle_.at(column, row) = met_[i].triangle;
        }
        made_.grey.at(column, row) = static_cast<float>(grey / samples_);
    }

    const MeshSight& sight_;
    const MeshRays& mesh_;
    const float paper_;
    const std::uint32_t samples_;
    Modalities& made_;
    Raster<std::uint32_t>& triangle_;
    std::array<SightRay, MeshRays::packet> rays_;
    std::array<MeshRay, MeshRays::packet> inLayer_;
    std::array<MeshMeeting, MeshRays::packet> met_;
};

}  // namespace

MeshModalities modalitiesOf(const MeshSurface& surface, const glm::dmat4& transform, const InkStyle& style,
                            const FramePlan& plan, const std::stop_token& stop) {
    const float paper = style.inkIsDark ? 1.0F : 0.0F;
    const std::uint32_t width = plan.width, height = plan.height;
    MeshModalities made{{.grey = Raster<float>(width, height, paper),
                         .depth = Raster<float>(width, height, HUGE_VALF),
                         .angle = Raster<float>(width, height),
                         .part = Raster<std::uint32_t>(width, height, Modalities::nothing)},
                        Raster<std::uint32_t>(width, height, MeshMeeting::none)};
    const MeshStyle mesh = white(style);
    const MeshSight sight(plan, transform, mesh, surface, 1.0);
    made.modalities.extent = std::max(sight.farDepth() - sight.nearDepth(), 1e-300);
    tbb::parallel_for(std::uint32_t{0}, plan.height, [&](std::uint32_t row) {
        if (!stop.stop_requested()) RowMaker(sight, surface.rays(), paper, plan.exact, made).make(row);
    });
    return made;
}

}  // namespace mote::render
