// SPDX-License-Identifier: GPL-3.0-or-later
//
// thinSurface: from even points on a surface to a hierarchy. Again and again the point with the smallest cell
// is removed and its neighbours move by Lloyd's method, each in its own tangent plane, back to the surface
// along a geodesic (dissertation 2.2.2.2). Points that are far apart are removed together, so that all
// threads work; the result is the same on any number of them.
#pragma once

#include "preprocess/job.h"
#include "preprocess/stipple/surface/surface_cell.h"
#include "preprocess/stipple/thinning.h"
#include "protocol/base/error.h"
#include "storage/stipple/stipple_hierarchy.h"

namespace mote::prep {

/// A point is locked, and does not move, while its neighbourhood cannot be flattened (flatEnough); the
/// hierarchy says of each whether it ever was. Reports progress from `begin` to 1. Errors: cancelled.
Result<storage::StippleHierarchy> thinSurface(const WalkMesh& mesh, PointSet set,
                                              const ThinningOptions& options, double begin,
                                              Progress& progress);

}  // namespace mote::prep
