// SPDX-License-Identifier: GPL-3.0-or-later
//
// TriangleIntersections: where triangles of a mesh cut each other. Whoever asks for a pair gets the same
// answer, to the last bit. Refers to the mesh; any number of threads may ask.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>

#include "storage/mesh/surface_mesh.h"

namespace mote::storage {

class TriangleIntersections {
  public:
    explicit TriangleIntersections(const SurfaceMesh& mesh);

    /// World units: what is so near to a plane lies in it. Some steps of the greatest coordinate's float, as
    /// places in a file are rounded.
    double tolerance() const { return tolerance_; }

    /// How far a triangle's corners lie above the plane of another one; exactly 0 within the tolerance, and
    /// of one without area.
    std::array<double, 3> heights(std::uint32_t triangle, std::uint32_t plane) const;

    /// The straight line along which two triangles cut each other, world units. None if they share an
    /// edge, lie in one plane, or have no more than a place in common. A corner in the other's plane counts
    /// as above it, so that of the triangles on either side of an edge that lies there one is cut. The
    /// triangles beside these two have the same ends where their lines go on.
    std::optional<std::array<glm::dvec3, 2>> between(std::uint32_t one, std::uint32_t other) const;

  private:
    using Corners = std::array<glm::dvec3, 3>;
    Corners cornersOf(std::uint32_t triangle) const;

    const SurfaceMesh& mesh_;
    double tolerance_;
    double grid_ = 1.0;  // on which ends lie
};

}  // namespace mote::storage
