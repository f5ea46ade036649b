// SPDX-License-Identifier: GPL-3.0-or-later
//
// PointMap: where the packed positions of a layer's points fall on the screen, ready for vectors: linear in
// the place of the leaf's cell and in the place within it. A value, made once a picture.
#pragma once

#include <array>
#include <cstdint>

#include "server/render/cpu/leaf_cells.h"
#include "server/render/plan/frame_plan.h"

namespace mote::render {

struct PointMap {
    /// Rows of what a point is mapped to: px * w, py * w, slab, w (screen_map.h).
    enum Row : std::size_t { rowX, rowY, rowSlab, rowW, rows };
    template <class Number>
    using Rows = std::array<Number, rows>;

    /// The plot's whole box: double, for a view that looks closely at a large plot.
    std::array<Rows<double>, 3> edge;  ///< along x, y and z
    Rows<double> corner;
    /// One step of a position, a 65536th of a cell, along x, y and z; by the cell's level.
    std::array<std::array<Rows<float>, 3>, deepestLeafLevel + 1> step;

    std::uint32_t width = 0;   ///< pixels
    std::uint32_t height = 0;  ///< pixels
    SlabBends bends;           ///< of rowSlab
    bool perspective = false;
    float nearest = 0.0F;  ///< nothing nearer is seen by a perspective eye: least w

    std::uint32_t slabs() const { return bends.slabs; }
    /// No edge of the box is longer on the screen, pixels, wherever in the picture; infinite where the box
    /// reaches behind the eye.
    double longestEdge() const;
    static PointMap make(const FramePlan& plan, const PointsPlan& layer);
};

}  // namespace mote::render
