// SPDX-License-Identifier: GPL-3.0-or-later
//
// Polygons of very many corners, cut into triangles by their ears, too, but with a grid of the corners that
// may lie in one. A function without state.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "preprocess/mesh/triangle_mesh.h"

namespace mote::prep {

/// Adds the triangles. `normal` is the polygon's; where it is 0, it has no area.
void cutLargePolygon(ExactMesh& mesh, std::span<const std::uint32_t> corners, const glm::dvec3& normal);

}  // namespace mote::prep
