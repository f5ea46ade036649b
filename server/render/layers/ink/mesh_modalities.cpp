// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/mesh_modalities.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "protocol/scene/srgb.h"
#include "protocol/scene/write_fields.h"
#include "server/render/ink/complexity.h"
#include "server/render/layers/ink/ambient_occlusion.h"
#include "server/render/layers/mesh/mesh_sight.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

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
           style.hatch.strength > 0.0 || style.solid.strength > 0.0;
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
            made_.angle.at(column, row) = glm::length(across) > leastAcross ? angleOf(across) : 0.0F;
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
    // One after the other: g++ 12 frees what is in inner braces twice where what follows them throws.
    MeshModalities made;
    made.modalities.grey = Raster<float>(width, height, paper);
    made.modalities.depth = Raster<float>(width, height, HUGE_VALF);
    made.modalities.angle = Raster<float>(width, height);
    made.modalities.part = Raster<std::uint32_t>(width, height, Modalities::nothing);
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

}  // namespace mote::render
