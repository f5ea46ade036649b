// SPDX-License-Identifier: GPL-3.0-or-later
//
// An ink layer becomes strokes, or fragments where it shows one of the pictures that its drawing is made from
// (docs/INK.md).
#pragma once

#include "server/render/layers/lowering.h"
#include "server/render/layers/mesh/mesh_surface.h"

namespace mote::render {

/// Uses all threads of the calling arena; the same strokes on any number of them. Throws std::bad_alloc.
void lowerInk(const Layer& layer, const InkStyle& style, const MeshSurface& surface, Lowering& out);

}  // namespace mote::render
