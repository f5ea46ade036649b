// SPDX-License-Identifier: GPL-3.0-or-later
//
// ToneGrid: how dark a picture is as the eye blurs it, in cells that are small beside the blur: what a
// drawing is compared with its target by. A value; pure functions.
//
// Tone as a drawing adds it up: independent layers of ink that cover shares a and b of the paper leave
// (1 - a)(1 - b) of it bare, so their densities -ln(1 - share) add. Pure.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "server/render/ink/raster.h"

namespace mote::render {

/// As dark as anything is wanted.
inline constexpr double mostCover = 0.98;

inline double densityOf(double cover) {
    return -std::log(1.0 - std::clamp(cover, 0.0, mostCover));
}

inline double coverOf(double density) {
    return 1.0 - std::exp(-density);
}

/// How places of a picture lie in cells of several pixels.
struct ToneCells {
    /// `reading`: standard deviation of the blur, pixels: a cell is at most half of it.
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
/// length in there. Nothing of what lies beside the grid. (Amanatides and Woo 1987, A Fast Voxel Traversal
/// Algorithm for Ray Tracing.)
template <class Take>
void eachSquare(glm::dvec2 from, glm::dvec2 to, std::uint32_t columns, std::uint32_t rows, const Take& take);

/// Cuts a line to 0 <= coordinate <= most along an axis; false if nothing is left.
inline bool cutToGrid(glm::dvec2& from, glm::dvec2& to, int axis, double most) {
    for (const double limit : {0.0, most}) {
        const double side = limit == 0.0 ? 1.0 : -1.0;
        const double atFrom = side * (from[axis] - limit), atTo = side * (to[axis] - limit);
        if (atFrom < 0.0 && atTo < 0.0) return false;
        if (atFrom >= 0.0 && atTo >= 0.0) continue;
        const glm::dvec2 crossing = from + atFrom / (atFrom - atTo) * (to - from);
        (atFrom < 0.0 ? from : to) = crossing;
    }
    return true;
}

template <class Take>
void eachSquare(glm::dvec2 from, glm::dvec2 to, std::uint32_t columns, std::uint32_t rows, const Take& take) {
    if (!cutToGrid(from, to, 0, columns) || !cutToGrid(from, to, 1, rows)) return;
    const glm::dvec2 way = to - from;
    const double length = glm::length(way);
    if (!(length > 0.0)) return;
    const auto square = [](double at, std::uint32_t count) {
        return static_cast<std::int64_t>(std::clamp(std::floor(at), 0.0, count - 1.0));
    };
    std::int64_t at[2] = {square(from.x, columns), square(from.y, rows)};
    const std::int64_t last[2] = {square(to.x, columns), square(to.y, rows)};
    const std::int64_t sides = std::abs(last[0] - at[0]) + std::abs(last[1] - at[1]);
    double begin = 0.0;
    const auto leaves = [&](int axis) {
        if (at[axis] == last[axis]) return 2.0;
        const double side = static_cast<double>(way[axis] > 0.0 ? at[axis] + 1 : at[axis]);
        return (side - from[axis]) / way[axis];
    };
    for (std::int64_t i = 0; i <= sides; ++i) {
        const int axis = leaves(0) < leaves(1) ? 0 : 1;
        const double end = std::clamp(leaves(axis), begin, 1.0);
        take(static_cast<std::uint32_t>(at[0]), static_cast<std::uint32_t>(at[1]), (end - begin) * length);
        begin = end;
        if (i < sides) at[axis] += at[axis] < last[axis] ? 1 : at[axis] > last[axis] ? -1 : 0;
    }
}

}  // namespace mote::render
