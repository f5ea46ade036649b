// SPDX-License-Identifier: GPL-3.0-or-later
//
// WalkMesh: a surface that points lie on and move over, along straightest geodesics. Immutable once made; any
// thread. It refers to the mesh that it was made from, which must outlive it.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "preprocess/mesh/surface_topology.h"

namespace mote::prep {

/// A place on the surface.
struct SurfacePoint {
    glm::dvec3 position{0.0};    ///< world units
    std::uint32_t triangle = 0;  ///< in which it lies
};

/// Cosine of the angle from which on an edge is a border: what lies behind it cannot be seen in one plane
/// with what lies before it, so each side is stippled as a patch of its own.
inline constexpr double borderCosine = 0.17;  // 80 degrees

class WalkMesh {
  public:
    static constexpr std::uint32_t none = storage::MeshEdge::none;

    /// What is asked of a triangle again and again, side by side in memory.
    struct Facet {
        glm::vec3 normal;
        glm::vec3 center;  ///< of a ball around the triangle
        float radius;      ///< its radius
        /// Across the edge from corner i on; none at a border.
        std::array<std::uint32_t, 3> neighbours;
    };

    WalkMesh(const storage::SurfaceMesh& mesh, const TriangleNeighbours& neighbours);

    const storage::SurfaceMesh& mesh() const { return mesh_; }
    std::size_t triangles() const { return mesh_.triangles.size(); }
    double area() const { return area_; }  ///< square world units
    double area(std::uint32_t triangle) const { return areas_[triangle]; }
    glm::dvec3 corner(std::uint32_t triangle, std::uint32_t corner) const {
        return glm::dvec3(mesh_.positions[mesh_.triangles[triangle][corner]]);
    }
    const Facet& facet(std::uint32_t triangle) const { return facets_[triangle]; }

    /// The surface's normal at a place, smooth across edges that are no creases; unit length.
    glm::dvec3 normalAt(const SurfacePoint& point) const;

    /// Where a straightest geodesic (Polthier and Schmies 1998) ends that begins along `step`, a vector whose
    /// length is the way to go: turned into the triangle's plane, and at each edge into the next one's. Ends
    /// at a border, and after 10,000 triangles.
    SurfacePoint walk(SurfacePoint point, const glm::dvec3& step) const;

  private:
    const storage::SurfaceMesh& mesh_;
    std::vector<Facet> facets_;
    std::vector<double> areas_;
    double area_ = 0.0;
};

}  // namespace mote::prep
