// SPDX-License-Identifier: GPL-3.0-or-later
//
// A mesh layer becomes fragments (docs/PICTURE.md, "Meshes"): rays through the pixels find its triangles.
#pragma once

#include <memory>

#include "server/render/layers/lowering.h"
#include "server/render/layers/mesh/mesh_surface.h"

namespace mote::render {

/// Its fragments are made where they are drawn.
void lowerMesh(const Layer& layer, const MeshStyle& style, std::shared_ptr<const MeshSurface> surface,
               Lowering& out);

}  // namespace mote::render
