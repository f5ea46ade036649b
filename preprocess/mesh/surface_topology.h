// SPDX-License-Identifier: GPL-3.0-or-later
//
// The topology of a welded mesh: which triangles meet at which edges, and from it the SurfaceMesh that a
// dataset holds. Pure functions; any thread.
#pragma once

#include <vector>

#include "preprocess/mesh/triangle_mesh.h"
#include "storage/mesh/surface_mesh.h"

namespace mote::prep {

/// The triangle on the other side of each triangle's edge from corner i to corner i + 1; MeshEdge::none at a
/// border and where more than two meet.
using TriangleNeighbours = std::vector<std::array<std::uint32_t, 3>>;

TriangleNeighbours findNeighbours(const std::vector<Triangle>& triangles);

/// The same from the edges of a dataset's mesh.
TriangleNeighbours neighboursOf(const storage::SurfaceMesh& mesh);

/// The dataset's mesh: a vertex becomes several where its triangles fall into groups that meet at no edge, or
/// only at creases, so that each has the normal of its own smooth piece, weighted by the triangles' angles
/// (Thürmer and Wüthrich 1998). A crease is an edge whose triangles' normals differ by more than 40 degrees:
/// a prism of ten sides is smooth, one of eight is not.
storage::SurfaceMesh makeSurfaceMesh(const TriangleMesh& mesh);

}  // namespace mote::prep
