// SPDX-License-Identifier: GPL-3.0-or-later
//
// TriangleMesh: triangles over shared vertices, as a reader leaves them and as welding makes them fit for
// use. Values; any thread.
//
// Welding: from what a reader leaves to triangles that can be walked over: vertices at one place become one,
// and what has no area, is not finite, or is there twice goes. Pure; the order of what stays is the file's.
//
// orderInSpace: a mesh whose triangles are near in memory where they are near in space, whatever the order of
// its file. A pure function; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "protocol/base/error.h"

namespace mote::prep {

using Triangle = std::array<std::uint32_t, 3>;  ///< vertices, counterclockwise seen from outside

struct TriangleMesh {
    std::vector<glm::vec3> positions;  ///< the file's own units, `origin` taken off
    std::vector<Triangle> triangles;
    std::vector<std::uint32_t> parts = {};  ///< [T] numbers of any order; empty: all are one
    glm::dvec3 origin{0.0};                 ///< not 0 where floats would be too coarse there
    std::uint64_t smallFaces = 0;           ///< of fewer than three corners, left out
    std::uint64_t tangled = 0;              ///< polygons of very many corners whose triangles may overlap
    std::vector<std::string> notes = {};    ///< what else was put right, a sentence each
};

/// The same while a file is read: every number as it stands there.
struct ExactMesh {
    std::vector<glm::dvec3> positions;
    std::vector<Triangle> triangles;
    std::vector<std::uint32_t> parts = {};
    std::uint64_t smallFaces = 0, tangled = 0;
    std::vector<std::string> notes = {};
    std::uint64_t cutting = 0;  ///< work that cutting its polygons took
};

/// What to take off places between `low` and `high` so that floats keep them apart: 0 where the step of a
/// float is less than 1e-5 of the box's longest side, else round numbers near the box's middle.
glm::dvec3 originFor(const glm::dvec3& low, const glm::dvec3& high);

/// Takes off the origin for those vertices that triangles use.
TriangleMesh toFloats(ExactMesh mesh);

/// A sentence that says so; empty if none was taken off.
std::string describeOrigin(const glm::dvec3& origin);

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
    std::uint64_t smallFaces = 0;  ///< left out: fewer than three corners
    std::uint64_t tangled = 0;     ///< polygons of very many corners whose triangles may overlap
};

/// Adds a polygon as triangles: ears are cut off in the plane that fits it best, so that one that is not
/// convex keeps its shape, however many corners it has; all polygons of a mesh that take more than some
/// seconds together are counted as tangled. Fewer than three corners are counted, and add nothing. All
/// indices are below the number of positions.
void addPolygon(ExactMesh& mesh, std::span<const std::uint32_t> corners);

/// Adds to `counts` what it put right. A triangle has no area where two of its corners are one, or its height
/// is below 1e-7 of its longest edge, the resolution of its coordinates.
TriangleMesh weldMesh(TriangleMesh mesh, MeshCounts& counts);

/// Sorts the triangles by the Morton keys of their middles in the box of the mesh, of equals by their place
/// in the file. Each keeps its part. Vertices stay.
void orderInSpace(TriangleMesh& mesh);

}  // namespace mote::prep
