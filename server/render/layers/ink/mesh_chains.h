// SPDX-License-Identifier: GPL-3.0-or-later
//
// Visible pieces of edges become long lines on the screen (docs/INK.md, "Lines"). Pure; many threads work at
// it.
#pragma once

#include <optional>
#include <stop_token>
#include <vector>

#include "server/render/ink/ink_line.h"
#include "server/render/layers/ink/edge_line.h"
#include "server/render/layers/mesh/mesh_surface.h"

namespace mote::render {

/// Pieces that follow one another as long lines on the screen, with the depth steps beside them. `extent`: of
/// Modalities; without it no steps are found.
std::vector<InkLine> chained(const MeshSurface& surface, const LineView& view,
                             const std::vector<EdgeLine>& pieces, std::optional<double> extent,
                             const std::stop_token& stop);

}  // namespace mote::render
