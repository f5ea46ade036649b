// SPDX-License-Identifier: GPL-3.0-or-later
//
// The points that a surface hierarchy starts from: as many on every piece of the surface as its area asks
// for, made even by Lloyd's method with over-relaxation, in tangent planes. The same on any number of
// threads.
#pragma once

#include <cstdint>

#include "preprocess/progress.h"
#include "preprocess/stipple/surface/surface_cell.h"
#include "protocol/scene/error.h"

namespace mote::prep {

/// Spacing of so many points in a hexagonal grid on so large an area.
double hexagonalSpacing(double area, std::size_t points);

/// The grid, filled anew with the points for which `within` holds, and the spacing of as many.
void refill(PointSet& set, const WalkMesh& mesh, const std::vector<bool>& within, std::size_t count);

/// One point in each of as many equal shares of the area, in the order of the triangles. At least one.
PointSet scatterPoints(const WalkMesh& mesh, std::uint32_t points, std::uint64_t seed);

/// One step: each point goes `relaxation` times the way to the centroid of its cell, but no more than half a
/// spacing. Returns the
/// mean length of the ways, in spacings.
double relaxOnce(const WalkMesh& mesh, PointSet& set, double relaxation);

/// scatterPoints, relaxed. Reports progress from 0 to `share`. Errors: cancelled.
Result<PointSet> evenSurfacePoints(const WalkMesh& mesh, std::uint32_t points, std::uint64_t seed,
                                   double share, Progress& progress);

}  // namespace mote::prep
