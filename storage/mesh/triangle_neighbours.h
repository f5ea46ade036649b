// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which triangles meet at which edges: of a mesh in which one place is one vertex. Pure functions; any
// thread.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "storage/mesh/surface_mesh.h"

namespace mote::storage {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;  ///< vertices

/// The triangle on the other side of each triangle's edge from corner i to corner i + 1; MeshEdge::none at a
/// border and where more than two meet.
using TriangleNeighbours = std::vector<std::array<std::uint32_t, 3>>;

TriangleNeighbours findNeighbours(const Triangles& triangles);

/// The edges of a mesh with these neighbours, whatever its vertices are.
std::vector<MeshEdge> edgesOf(const Triangles& triangles, const TriangleNeighbours& neighbours);

}  // namespace mote::storage
