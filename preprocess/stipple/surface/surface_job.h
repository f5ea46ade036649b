// SPDX-License-Identifier: GPL-3.0-or-later
//
// The stipple job on a mesh: a dataset of kind "stipple" whose hierarchy lies on a surface, with the mesh
// beside it. Points start as many on every piece of the surface as its area asks for, made even by Lloyd's
// method with over-relaxation, in tangent planes. Called from one thread. The same request and file give the
// same bytes on any number of threads.
#pragma once

#include <cstdint>
#include <filesystem>

#include "preprocess/job.h"
#include "preprocess/stipple/stipple_job.h"
#include "preprocess/stipple/surface/surface_cell.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::prep {

/// Spacing of so many points in a hexagonal grid on so large an area.
double hexagonalSpacing(double area, std::size_t points);

/// The grid, filled anew with the points for which `within` holds, and the spacing of as many.
void refill(PointSet& set, const WalkMesh& mesh, const std::vector<bool>& within, std::size_t count);

/// Puts one point in each of as many equal shares of the area, in the order of the triangles. At least one.
PointSet scatterPoints(const WalkMesh& mesh, std::uint32_t points, std::uint64_t seed);

/// Does one step: each point goes `relaxation` times the way to the centroid of its cell, but no more than
/// half a spacing. Returns the mean length of the ways, in spacings.
double relaxOnce(const WalkMesh& mesh, PointSet& set, double relaxation);

/// scatterPoints, relaxed. Reports progress from 0 to `share`. Errors: cancelled.
Result<PointSet> evenSurfacePoints(const WalkMesh& mesh, std::uint32_t points, std::uint64_t seed,
                                   double share, Progress& progress);

/// Makes `output`, which appears by one rename, from the mesh in the file `input`. Returns its manifest.
/// Errors: those of readMesh (preprocess/mesh/read_mesh.h), invalidArgument, alreadyExists, permissionDenied,
/// resourceExhausted (memory, disk), cancelled.
Result<proto::Manifest> runSurfaceJob(const proto::JobRequest& request, const std::filesystem::path& input,
                                      const std::filesystem::path& output, const JobResources& resources,
                                      Progress& progress);

}  // namespace mote::prep
