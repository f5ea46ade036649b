// SPDX-License-Identifier: GPL-3.0-or-later
//
// A mesh layer becomes fragments (docs/PICTURE.md, "Meshes"): rays through the pixels find its triangles.
#pragma once

#include "server/render/layers/lowering.h"
#include "server/render/layers/mesh/mesh_surface.h"

namespace mote::render {

/// Uses all threads of the calling arena; the same fragments on any number of them. Throws std::bad_alloc,
/// also where a surface of many layers would make more fragments than fit.
void lowerMesh(const Layer& layer, const MeshStyle& style, const MeshSurface& surface, Lowering& out);

}  // namespace mote::render
