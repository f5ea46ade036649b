// SPDX-License-Identifier: GPL-3.0-or-later
//
// StippleSurface: what a stippled surface is drawn from: its hierarchy and the mesh that hides some of it.
// Made once for a dataset, immutable, shared by pictures.
#pragma once

#include <glm/vec3.hpp>

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "protocol/scene/bounds.h"
#include "server/render/layers/stipple/replay.h"

namespace mote::render {

/// Tells whether a triangle mesh lies in the way of a ray (Embree). Made once for a dataset, immutable; any
/// number of threads may ask.
class SurfaceRays {
  public:
    /// Copies the mesh. Throws std::bad_alloc if memory runs out.
    SurfaceRays(std::span<const glm::vec3> positions,
                std::span<const std::array<std::uint32_t, 3>> triangles);
    ~SurfaceRays();
    SurfaceRays(SurfaceRays&&) noexcept;
    SurfaceRays& operator=(SurfaceRays&&) noexcept;

    /// Whether a triangle is met between `from` and `from` + `reach` * `direction`; `reach` may be infinite.
    bool blocked(const glm::vec3& from, const glm::vec3& direction, float reach) const;

    /// That it takes in memory, its tree included, as Embree counts them.
    std::uint64_t bytes() const;

  private:
    struct Scene;
    std::unique_ptr<const Scene> scene_;
};

class StippleSurface {
  public:
    /// `area`: of the mesh, in its own units; above 0.
    StippleSurface(StippleReplay replay, SurfaceRays rays, const Bounds& bounds, double area);

    const StippleReplay& replay() const { return replay_; }
    const SurfaceRays& rays() const { return rays_; }
    /// The mesh's bounds, layer space.
    const Bounds& bounds() const { return bounds_; }
    /// Points an area if all are drawn.
    double density() const { return density_; }
    /// Rays start this far off the surface, a twentieth of the mean distance of points: what lies closer
    /// together hides nothing.
    float tolerance() const { return tolerance_; }
    /// That it takes in memory.
    std::uint64_t bytes() const { return replay_.bytes() + rays_.bytes(); }

    /// Whether the surface hides a place on it from a direction or, if it is `reach` away, a place in that
    /// direction. `normal`: there, unit, on either side.
    bool hides(const glm::vec3& place, const glm::vec3& normal, const glm::vec3& direction,
               float reach) const;

  private:
    StippleReplay replay_;
    SurfaceRays rays_;
    Bounds bounds_;
    double density_;
    float tolerance_;
};

}  // namespace mote::render
