// SPDX-License-Identifier: GPL-3.0-or-later
//
// LineTrial: whether a place on an edge of a large mesh is seen, by a plain trial of all triangles that lie
// over its part of the picture: no ray tracer, no code of the renderer's. Meshes that lie wholly in front of
// the eye. Refers to the mesh; any number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "protocol/scene/camera.h"
#include "storage/mesh/surface_mesh.h"

namespace mote::bench {

class LineTrial {
  public:
    /// World space is layer space. Throws std::invalid_argument where a vertex does not lie in front of the
    /// eye.
    LineTrial(const storage::SurfaceMesh& mesh, const Camera& camera, std::uint32_t width,
              std::uint32_t height);

    /// On the picture, pixels.
    glm::dvec2 onScreen(const glm::dvec3& inEye) const;
    glm::dvec3 inEye(std::uint32_t vertex) const { return eye_[vertex]; }
    /// Whether no triangle but two lies nearer to the eye.
    bool seen(const glm::dvec3& inEye, const std::array<std::uint32_t, 2>& own) const;
    /// 1 where a triangle's front is seen, -1 its back, 0 where it is seen nearly edge-on.
    int side(std::uint32_t triangle) const;

  private:
    std::size_t tileOf(const glm::dvec2& place) const;

    const storage::SurfaceMesh& mesh_;
    bool perspective_;
    double width_, height_, unit_;
    double gap_;  // world units: what is nearer by less hides nothing
    std::vector<glm::dvec3> eye_;
    std::size_t columns_, rows_;
    std::vector<std::vector<std::uint32_t>> tiles_;  // triangles over them
};

}  // namespace mote::bench
