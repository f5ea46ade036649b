// SPDX-License-Identifier: GPL-3.0-or-later
//
// SurfaceMesh: a triangle mesh as datasets hold it: for shading, for rays against it, and for silhouettes. A
// value; whoever reads or makes it owns it.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "protocol/base/error.h"

namespace mote::storage {

/// An edge and the triangles on its sides. If more than two triangles meet, or one lies alone, there is an
/// edge for each of them, with nothing on its other side.
struct MeshEdge {
    static constexpr std::uint32_t none = UINT32_MAX;

    /// Ends, as vertices of triangles[0], in that triangle's direction.
    std::array<std::uint32_t, 2> vertices{};
    std::array<std::uint32_t, 2> triangles{none, none};

    friend bool operator==(const MeshEdge&, const MeshEdge&) = default;
};

struct SurfaceMesh {
    std::vector<glm::vec3> positions;  ///< [V] world units; one place may have several vertices: at a crease
    std::vector<glm::vec3> normals;    ///< [V] unit length, outwards if triangles are counterclockwise
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< [T] vertices
    std::vector<MeshEdge> edges;                          ///< [E] by their first triangle
    /// [T] of each triangle, numbered from 0 in the order of their first triangles; empty: all are one.
    std::vector<std::uint32_t> parts = {};
    /// [I] pairs of triangles that cut each other along a line (triangle_intersection.h).
    std::vector<std::array<std::uint32_t, 2>> intersections = {};
};

/// Whether indices are in range, numbers finite, normals of unit length and parts numbered in order, and
/// ends of intersections, two each, can be counted with the vertices. Errors:
/// corrupt, with the array's name ("/mesh/triangle").
Status checkSurfaceMesh(const SurfaceMesh& mesh);

}  // namespace mote::storage
