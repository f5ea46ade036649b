// SPDX-License-Identifier: GPL-3.0-or-later
//
// The edges of a mesh that are lines of a drawing (docs/INK.md, "Lines"). Pure; many threads work at it.
#pragma once

#include <stop_token>
#include <vector>

#include "server/render/layers/ink/edge_line.h"
#include "server/render/layers/mesh/mesh_surface.h"

namespace mote::render {

/// Silhouettes and borders, and creases where the surface turns by at least `crease` degrees; whole edges,
/// seen or not, that are in front of the eye and not far beside the picture. In the order of the mesh's
/// edges. Behind them, below 180 degrees, as creases where the surface cuts itself.
std::vector<EdgeLine> linesOf(const MeshSurface& surface, const LineView& view, double crease,
                              const std::stop_token& stop);

}  // namespace mote::render
