// SPDX-License-Identifier: GPL-3.0-or-later
//
// The topology of a welded mesh: which triangles meet at which edges, and from it the SurfaceMesh that a
// dataset holds. Pure functions; any thread.
#pragma once

#include <vector>

#include "preprocess/mesh/triangle_mesh.h"
#include "storage/mesh/triangle_neighbours.h"

namespace mote::prep {

using storage::findNeighbours;
using storage::TriangleNeighbours;

/// Neighbours from the edges of a dataset's mesh.
TriangleNeighbours neighboursOf(const storage::SurfaceMesh& mesh);

/// The dataset's mesh: a vertex becomes several where its triangles fall into groups that meet at no edge, or
/// only at creases, so that each has the normal of its own smooth piece, weighted by the triangles' angles
/// (Thürmer and Wüthrich 1998). A crease is an edge whose triangles' normals differ by more than 40 degrees:
/// a prism of ten sides is smooth, one of eight is not.
storage::SurfaceMesh makeSurfaceMesh(const TriangleMesh& mesh);

}  // namespace mote::prep
