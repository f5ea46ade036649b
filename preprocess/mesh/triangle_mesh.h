// SPDX-License-Identifier: GPL-3.0-or-later
//
// TriangleMesh: triangles over shared vertices, as a reader leaves them and as welding (weld_mesh.h) makes
// them fit for use. Values; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace mote::prep {

using Triangle = std::array<std::uint32_t, 3>;  ///< vertices, counterclockwise seen from outside

struct TriangleMesh {
    std::vector<glm::vec3> positions;  ///< the file's own units
    std::vector<Triangle> triangles;
    std::vector<std::uint32_t> parts = {};  ///< [T] numbers of any order; empty: all are one
};

/// What reading and welding met and put right.
struct MeshCounts {
    std::uint64_t vertices = 0;    ///< in the file
    std::uint64_t triangles = 0;   ///< of all polygons of the file
    std::uint64_t notFinite = 0;   ///< triangles left out: a corner is no place (storage/places.h)
    std::uint64_t duplicates = 0;  ///< vertices at the place of another one: merged
    std::uint64_t degenerate = 0;  ///< triangles left out: no area
    std::uint64_t repeated = 0;    ///< triangles left out: another one has the same three corners
    std::uint64_t needles = 0;  ///< triangles kept whose height is below a thousandth of their longest edge
    std::uint64_t unused = 0;   ///< vertices left out: in no triangle
};

/// Adds a polygon as triangles: ears are cut off in the plane that fits it best, so that one that is not
/// convex keeps its shape; a fan where it has more than 64 corners. Fewer than three corners add nothing. All
/// indices are below the number of positions.
void addPolygon(TriangleMesh& mesh, std::span<const std::uint32_t> corners);

}  // namespace mote::prep
