// SPDX-License-Identifier: GPL-3.0-or-later
//
// How even points on a surface are: the measures of a distribution on the plane, taken in the tangent plane
// at each point whose neighbourhood can be flattened. Pure functions; they work on all threads.
#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "preprocess/stipple/surface/surface_cell.h"
#include "tests/support/nearest_triangle.h"

namespace mote::test {

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
