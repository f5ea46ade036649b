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
    const auto within = [](float at, std::uint32_t side) {
        return static_cast<std::uint32_t>(std::clamp(at, 0.0F, static_cast<float>(side)));
    };
    const auto from = [&](float at, std::uint32_t side) {
        return within(std::floor(at - footprint.reach), side);
    };
    const auto to = [&](float at, std::uint32_t side) {
        return within(std::ceil(at + footprint.reach), side);
    };
    for (auto row = from(dot.y, size.height); row < to(dot.y, size.height); ++row) {
        for (auto column = from(dot.x, size.width); column < to(dot.x, size.width); ++column) {
            const float x = static_cast<float>(column) + 0.5F - dot.x;
            const float y = static_cast<float>(row) + 0.5F - dot.y;
            const float covers = footprint.coverage(std::hypot(x, y));
            if (covers > 0.0F) take(column, row, covers);
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
