// SPDX-License-Identifier: GPL-3.0-or-later
//
// The edges of a mesh that are lines of a drawing, and what is seen of them (docs/INK.md, "Lines"). Pure;
// many threads work at it.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <stop_token>
#include <vector>

#include "server/render/ink/ink_line.h"
#include "server/render/ink/raster.h"
#include "server/render/layers/ink/line_view.h"
#include "server/render/layers/mesh/mesh_surface.h"

namespace mote::render {

/// An edge of the mesh, or a visible piece of one.
struct EdgeLine {
    LineKind kind = LineKind::silhouette;
    std::array<std::uint32_t, 2> vertices{}, triangles{};  ///< as in storage::MeshEdge
    Span piece{0.0, 1.0};                                  ///< of the edge, world space
};

/// Silhouettes and borders, and creases where the surface turns by at least `crease` degrees; whole edges,
/// seen or not, that are in front of the eye and not far beside the picture. In the order of the mesh's
/// edges.
std::vector<EdgeLine> linesOf(const MeshSurface& surface, const LineView& view, double crease,
                              const std::stop_token& stop);

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

/// Pieces that follow one another as long lines on the screen, with the depth steps beside them. `extent`: of
/// Modalities.
std::vector<InkLine> chained(const MeshSurface& surface, const LineView& view,
                             const std::vector<EdgeLine>& pieces, double extent, const std::stop_token& stop);

}  // namespace mote::render
