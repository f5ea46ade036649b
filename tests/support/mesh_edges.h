// SPDX-License-Identifier: GPL-3.0-or-later
//
// The edges of generated meshes, found in the plainest way: by the places of their ends. Pure functions.
#pragma once

#include <memory>

#include "server/render/layers/mesh/mesh_surface.h"

namespace mote::test {

/// Where two triangles meet in opposite directions and no other there, one edge; else one for each triangle,
/// with nothing on its other side.
std::vector<storage::MeshEdge> edgesOf(const storage::SurfaceMesh& mesh);

/// A mesh with its edges and bounds.
std::shared_ptr<const render::MeshSurface> surfaceOf(storage::SurfaceMesh mesh);

}  // namespace mote::test
