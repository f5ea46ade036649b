// SPDX-License-Identifier: GPL-3.0-or-later
//
// orderInSpace: a mesh whose triangles are near in memory where they are near in space, whatever the order of
// its file. A pure function; any thread.
#pragma once

#include "preprocess/mesh/triangle_mesh.h"

namespace mote::prep {

/// Sorts the triangles by the Morton keys of their middles in the box of the mesh, of equals by their place
/// in the file. Each keeps its part. Vertices stay.
void orderInSpace(TriangleMesh& mesh);

}  // namespace mote::prep
