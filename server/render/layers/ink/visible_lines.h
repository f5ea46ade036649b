// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is seen of edges that are lines of a drawing (docs/INK.md, "Lines"). Pure; many threads work at it.
#pragma once

#include <stop_token>
#include <vector>

#include "server/render/ink/raster.h"
#include "server/render/layers/ink/edge_line.h"
#include "server/render/layers/mesh/mesh_surface.h"

namespace mote::render {

/// How what hides a line is sought.
struct HiderSearch {
    /// Pixels between places where it is; what hides less may be missed.
    double sampling;
    /// A triangle that is seen in each pixel of the picture, or MeshMeeting::none: it is tried first. Time
    /// depends on it, and what of narrower hiders is found.
    const Raster<std::uint32_t>* likely = nullptr;
    /// MeshModalities::farthest, or null: edges far behind all that is seen around them are hidden, and not
    /// looked at. Time depends on it, and what of them is seen through gaps narrower than a pixel.
    const Raster<float>* farthest = nullptr;
};

/// What of the edges no triangle but their own hides, in order. Where a triangle's shadow on an edge begins
/// and ends is exact.
std::vector<EdgeLine> visible(const MeshSurface& surface, const LineView& view,
                              const std::vector<EdgeLine>& edges, const HiderSearch& search,
                              const std::stop_token& stop);

}  // namespace mote::render
