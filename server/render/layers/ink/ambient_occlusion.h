// SPDX-License-Identifier: GPL-3.0-or-later
//
// AmbientOcclusion: how much of the light that comes from all sides a mesh's own surroundings keep away from
// places of it (Zhukov and others 1998, An ambient light illumination model). Refers to the surface; any
// number of threads.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "server/render/layers/mesh/mesh_surface.h"

namespace mote::render {

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

}  // namespace mote::render
