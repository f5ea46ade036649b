// SPDX-License-Identifier: GPL-3.0-or-later
//
// dotCells: of each dot, what is wanted in its Voronoi cell: how much, where its middle is and how it is
// spread. Cells are those of the pixels' centres, exactly. Pure; uses all threads of the calling arena and
// gives the same result on any number of them.
#pragma once

#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "server/render/layers/stipple/pixel_map.h"

namespace mote::render {

struct DotCell {
    double mass = 0.0;         ///< wanted dots in the cell: 1 where the tone is right
    glm::dvec2 centroid{0.0};  ///< pixels; the dot's own place if nothing is wanted
    /// Second moments about the centroid over the mass: along x, mixed, along y, square pixels.
    double xx = 0.0, xy = 0.0, yy = 0.0;
};

/// `dots` in pixels; those outside the picture have cells too, if they reach into it. What is wanted
/// further than 1024 pixels from any dot is nobody's.
std::vector<DotCell> dotCells(const PixelMap& wanted, std::span<const glm::vec2> dots);

}  // namespace mote::render
