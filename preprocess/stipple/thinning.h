// SPDX-License-Identifier: GPL-3.0-or-later
//
// thinPlane: from even points to a hierarchy: again and again the point with the smallest Voronoi cell is
// removed, and its neighbours move by Lloyd's method with everything else fixed (dissertation 2.2.2.1).
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <vector>

#include "preprocess/progress.h"
#include "protocol/scene/error.h"
#include "storage/stipple/stipple_hierarchy.h"

namespace mote::prep {

struct ThinningOptions {
    int rings = 2;            ///< of neighbours that move at a removal, 1 or 2; 0: a static hierarchy
    double relaxation = 1.6;  ///< times the way to the centroid of the cell
};

/// `points` lie on the periodic unit square, no two alike; at least one. One thread. Reports progress from
/// `begin` to 1. Errors: cancelled.
Result<storage::StippleHierarchy> thinPlane(const std::vector<glm::dvec2>& points,
                                            const ThinningOptions& options, double begin, Progress& progress);

}  // namespace mote::prep
