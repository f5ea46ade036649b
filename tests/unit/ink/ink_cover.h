// SPDX-License-Identifier: GPL-3.0-or-later
//
// What strokes cover of a picture, for tests: as devices draw them. Pure functions.
#pragma once

#include <glm/vec2.hpp>
#include <limits>
#include <vector>

#include "server/render/ink/raster.h"
#include "server/render/plan/stroke_fragments.h"

namespace mote::test {

inline void addStroke(render::Strokes& strokes, const std::vector<glm::dvec2>& places, double width) {
    const auto begin = static_cast<std::uint32_t>(strokes.points.size());
    for (const auto& at : places)
        strokes.points.push_back(
            {static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(width)});
    strokes.lines.push_back({begin, static_cast<std::uint32_t>(strokes.points.size())});
}

/// The share of each pixel that ink covers; strokes over one another as if independent.
inline render::Raster<double> coverOf(const render::Strokes& strokes, std::uint32_t width,
                                      std::uint32_t height) {
    render::Raster<double> bare(width, height, 1.0);
    constexpr double everywhere = -std::numeric_limits<double>::infinity();
    for (const auto& part : render::strokeFragments(strokes, width, height, everywhere)) {
        for (const auto& one : part) bare.at(one.column, one.row) *= 1.0 - static_cast<double>(one.opacity);
    }
    for (auto& value : bare.values) value = 1.0 - value;
    return bare;
}

/// Of pixels that are at least `border` from the picture's sides.
inline double meanOf(const render::Raster<double>& picture, std::uint32_t border) {
    double sum = 0.0, count = 0.0;
    for (std::uint32_t row = border; row + border < picture.height; ++row) {
        for (std::uint32_t column = border; column + border < picture.width; ++column) {
            sum += picture.at(column, row);
            count += 1.0;
        }
    }
    return sum / count;
}

}  // namespace mote::test
