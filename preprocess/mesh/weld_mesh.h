// SPDX-License-Identifier: GPL-3.0-or-later
//
// Welding: from what a reader leaves to triangles that can be walked over: vertices at one place become one,
// and what has no area, is not finite, or is there twice goes. Pure; the order of what stays is the file's.
#pragma once

#include "preprocess/mesh/triangle_mesh.h"
#include "protocol/scene/error.h"

namespace mote::prep {

/// Adds to `counts` what it put right. A triangle has no area where two of its corners are one, or its height
/// is below 1e-7 of its longest edge, the resolution of its coordinates.
TriangleMesh weldMesh(TriangleMesh mesh, MeshCounts& counts);

}  // namespace mote::prep
