// SPDX-License-Identifier: GPL-3.0-or-later
//
// The lines of a mesh (docs/INK.md, "Lines"): its edges that are lines of a drawing, what is seen of them,
// and how visible pieces become long lines. Pure; many threads work at each.
#pragma once

#include <optional>
#include <stop_token>
#include <vector>

#include "server/render/ink/ink_line.h"
#include "server/render/ink/modalities.h"
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

/// Returns what is seen of edges in a picture in motion, in their order: the depths that its pixels have tell
/// it, and lines stay the short pieces that the mesh's edges are. `modalities`: of the view.
std::vector<InkLine> quickLines(const MeshSurface& surface, const LineView& view,
                                const std::vector<EdgeLine>& edges, const Modalities& modalities,
                                const std::stop_token& stop);

/// Pieces that follow one another as long lines on the screen, with the depth steps beside them. `extent`: of
/// Modalities; without it no steps are found.
std::vector<InkLine> chained(const MeshSurface& surface, const LineView& view,
                             const std::vector<EdgeLine>& pieces, std::optional<double> extent,
                             const std::stop_token& stop);

/// Silhouettes and borders, and creases where the surface turns by at least `crease` degrees; whole edges,
/// seen or not, that are in front of the eye and not far beside the picture. In the order of the mesh's
/// edges. Behind them, below 180 degrees, as creases where the surface cuts itself.
std::vector<EdgeLine> linesOf(const MeshSurface& surface, const LineView& view, double crease,
                              const std::stop_token& stop);

/// Suggestive contours (DeCarlo, Finkelstein, Rusinkiewicz and Santella 2003, Suggestive Contours for
/// Conveying Shape), a piece in each triangle, seen or not: where the radial curvature, the surface's normal
/// curvature towards the eye, is zero and grows towards the eye by enough. In the order of the triangles.
std::vector<EdgeLine> suggestiveLines(const MeshSurface& surface, const LineView& view,
                                      const std::stop_token& stop);

/// Bytes that this takes meanwhile, at most, by a triangle.
inline constexpr double suggestiveBytes = 84.0;

}  // namespace mote::render
