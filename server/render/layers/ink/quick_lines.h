// SPDX-License-Identifier: GPL-3.0-or-later
//
// Lines of a mesh for a picture in motion: what is seen of them is told by the depths that the picture's
// pixels have, and they stay the short pieces that the mesh's edges are. Pure; many threads work at it.
#pragma once

#include <stop_token>
#include <vector>

#include "server/render/ink/ink_line.h"
#include "server/render/ink/modalities.h"
#include "server/render/layers/ink/edge_line.h"
#include "server/render/layers/mesh/mesh_surface.h"

namespace mote::render {

/// What is seen of edges, in their order. `modalities`: of the view.
std::vector<InkLine> quickLines(const MeshSurface& surface, const LineView& view,
                                const std::vector<EdgeLine>& edges, const Modalities& modalities,
                                const std::stop_token& stop);

}  // namespace mote::render
