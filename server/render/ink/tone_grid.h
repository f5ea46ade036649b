// SPDX-License-Identifier: GPL-3.0-or-later
//
// ToneGrid: how dark a picture is as the eye blurs it, in cells that are small beside the blur: what a
// drawing is compared with its target by. A value; pure functions.
#pragma once

#include <glm/vec2.hpp>

#include "server/render/ink/raster.h"

namespace mote::render {

/// How places of a picture lie in cells of several pixels.
struct ToneCells {
    /// `reading`: standard deviation of the blur, pixels: a cell is at most a third of it.
    ToneCells(std::uint32_t width, std::uint32_t height, double reading);

    std::uint32_t pixels;         ///< sides of a cell
    std::uint32_t columns, rows;  ///< that cover the picture
    double blur;                  ///< standard deviation, cells
};

using ToneGrid = Raster<float>;

/// The mean of a picture's pixels in each cell.
ToneGrid meansOf(const Raster<float>& picture, const ToneCells& cells);
/// Blurred by a Gaussian of a standard deviation in cells; what lies beside the grid is as its side.
ToneGrid blurred(const ToneGrid& grid, double deviation);
/// A grid's value at a place of the picture, pixels; between the middles of four cells.
float toneAt(const ToneGrid& grid, const ToneCells& cells, const glm::dvec2& place);

/// Calls take(column, row, length) for each square of a grid of unit squares that the line passes, with its
/// length in there. Nothing of what lies beside the grid.
template <class Take>
void eachSquare(glm::dvec2 from, glm::dvec2 to, std::uint32_t columns, std::uint32_t rows, const Take& take);

}  // namespace mote::render

#include "server/render/ink/each_square-inl.h"
