// SPDX-License-Identifier: GPL-3.0-or-later
//
// Where the shapes of a page are seen: the pixels and depths of dots, of lines and of areas, one way for
// those who ask what lies before them and those who cut them there. Pure functions.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/vec2.hpp>
#include <vector>

#include "server/encode/vector/sight.h"
#include "server/render/plan/dot.h"
#include "server/render/plan/stroke.h"

namespace mote::server {

struct PictureSize {
    std::uint32_t width = 0, height = 0;  ///< pixels
};

/// The pixel of the picture that holds a place, or the nearest to it.
inline glm::uvec2 pixelOf(const glm::dvec2& place, const PictureSize& size) {
    return {static_cast<std::uint32_t>(std::clamp(std::floor(place.x), 0.0, size.width - 1.0)),
            static_cast<std::uint32_t>(std::clamp(std::floor(place.y), 0.0, size.height - 1.0))};
}

/// `take(column, row, coverage)` for each pixel of the picture that a dot covers, row by row.
template <class Take>
void forCovered(const render::Dot& dot, const PictureSize& size, Take&& take) {
    const render::DotFootprint footprint(dot.radius);
    const auto from = [&](float at) { return std::max(0.0F, std::floor(at - footprint.reach)); };
    const auto to = [&](float at, std::uint32_t side) {
        return std::min(static_cast<float>(side), std::ceil(at + footprint.reach));
    };
    for (float row = from(dot.y); row < to(dot.y, size.height); ++row) {
        for (float column = from(dot.x); column < to(dot.x, size.width); ++column) {
            const float covers = footprint.coverage(std::hypot(column + 0.5F - dot.x, row + 0.5F - dot.y));
            if (covers > 0.0F)
                take(static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(row), covers);
        }
    }
}

/// Into how many equal pieces, each shorter than half a pixel, the way from one point to the next falls.
std::uint32_t piecesBetween(const render::StrokePoint& from, const render::StrokePoint& to);

/// At a share of the way.
render::StrokePoint pointBetween(const render::StrokePoint& from, const render::StrokePoint& to,
                                 double share);

/// The pixels around all points of a list of outlines, that are in the picture.
struct PixelBox {
    std::uint32_t left = 0, top = 0, right = 0, bottom = 0;  ///< right and bottom: behind the last
};
PixelBox boxOf(const render::Strokes& strokes, const render::InkArea& area, const PictureSize& size);

std::vector<SightPlace> placesOf(const render::Dots& dots, const PictureSize& size);
std::vector<SightPlace> placesOf(const render::Strokes& strokes, const PictureSize& size);

}  // namespace mote::server
