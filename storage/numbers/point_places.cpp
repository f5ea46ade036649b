// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/numbers/point_places.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "protocol/scene/camera.h"
#include "storage/particles/octree_cell.h"

namespace mote::storage {

std::size_t LeafWalk::leafOf(std::uint64_t point) const {
    const auto after = std::upper_bound(leaves_.pointBegin.begin(), leaves_.pointBegin.end(), point);
    return static_cast<std::size_t>(after - leaves_.pointBegin.begin()) - 1;
}

LeafWalk::Cell LeafWalk::cellOf(std::size_t node) const {
    const double edge = std::ldexp(2.0, -nodes_.level[node]);
    return {glm::dvec3(-1.0) + edge * glm::dvec3(cellPlace(nodes_.morton[node])), edge};
}

PictureMap::PictureMap(const Camera& camera, double aspect, const glm::dmat4& layerToWorld)
    : near_(camera.perspective() ? nearShare * glm::length(camera.target - camera.eye)
                                 : -std::numeric_limits<double>::infinity()),
      perspective_(camera.perspective()) {
    const glm::dmat4 rows = glm::transpose(camera.worldToEye() * layerToWorld);  // glm's are columns
    const double half = camera.halfHeight();
    x_ = rows[0] / (2.0 * half * aspect);
    y_ = -rows[1] / (2.0 * half);
    depth_ = -rows[2];
}

}  // namespace mote::storage
