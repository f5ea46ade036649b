// SPDX-License-Identifier: GPL-3.0-or-later
//
// The surface on which a volume has a value, as a triangle mesh: a vertex in each cell that the surface goes
// through, a quadrilateral around each edge between samples that it crosses (surface nets: Gibson,
// "Constrained elastic surface nets", MICCAI 1998), and vertices then moved along the gradient of the
// trilinear interpolation onto the surface. A pure function of what the source gives; it holds two slices of
// it.
#pragma once

#include <cstdint>
#include <optional>

#include "preprocess/job.h"
#include "preprocess/mesh/triangle_mesh.h"
#include "preprocess/volume/volume_source.h"
#include "protocol/base/error.h"
#include "protocol/scene/bounds.h"

namespace mote::prep {

struct IsosurfaceOptions {
    double value = 0.0;  ///< in the source's own unit; what is not below it is inside
    std::optional<Bounds> clip =
        {};  ///< world units; vertices elsewhere are left out, and the mesh is open there
    std::uint64_t mostTriangles = 0;
};

/// Triangles are counterclockwise seen from where values are lower, positions in world units, the
/// mesh's origin taken off. Where the volume ends, the mesh is open; samples that are not finite lie outside.
/// Errors: invalidArgument (no surface: with the range of values, or why else; a volume of less than two
/// samples along an axis), resourceExhausted (more triangles), cancelled, those of the source.
Result<TriangleMesh> isosurface(VolumeSource& source, const IsosurfaceOptions& options, Progress& progress);

}  // namespace mote::prep
