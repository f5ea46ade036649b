// SPDX-License-Identifier: GPL-3.0-or-later
//
// How even points on a surface are: the measures of a distribution on the plane, taken in the tangent plane
// at each point whose neighbourhood can be flattened. Pure functions; they work on all threads.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <vector>

#include "preprocess/stipple/surface/surface_cell.h"
#include "storage/mesh/surface_mesh.h"

namespace mote::test {

/// The place on a mesh that is nearest to a given one, by Embree's hierarchy of boxes.
/// Move-only; any thread may ask.
class NearestTriangle {
  public:
    struct Found {
        std::uint32_t triangle = 0;
        glm::dvec3 position{0.0};
        double distance = 0.0;  ///< world units
    };

    /// `mesh` must outlive it.
    explicit NearestTriangle(const storage::SurfaceMesh& mesh);
    NearestTriangle(NearestTriangle&&) noexcept;
    ~NearestTriangle();

    Found find(const glm::vec3& place) const;

  private:
    struct Scene;
    std::unique_ptr<Scene> scene_;
};

/// The place on a triangle that is nearest to a given one (Ericson, Real-Time Collision Detection, 5.1.5).
glm::dvec3 nearestOnTriangle(const glm::dvec3& place, const glm::dvec3& a, const glm::dvec3& b,
                             const glm::dvec3& c);

struct SurfaceMeasures {
    std::size_t points = 0;
    std::size_t flat = 0;  ///< those that are measured
    double rho = 0.0;      ///< least distance of two of them, over that in a hexagonal grid of as many points
    double nearest = 0.0;  ///< mean distance to the nearest, where that is one of them, over the same
    double energy = 0.0;   ///< second moments of the cells about their points, over those of hexagons
    double areaCv = 0.0;   ///< standard deviation of the cells' areas over their mean
    double worstArea = 0.0;  ///< the largest cell over the mean
};

/// Where they lie on the mesh, by the nearest triangle, and in a grid.
prep::PointSet placeOnSurface(const prep::WalkMesh& mesh, const NearestTriangle& nearest,
                              std::span<const glm::vec3> positions);

SurfaceMeasures measureSurface(const prep::WalkMesh& mesh, const prep::PointSet& set);

}  // namespace mote::test
