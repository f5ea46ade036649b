// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/vector/shape_places.h"

#include <glm/common.hpp>
#include <limits>

namespace mote::server {
namespace {

using render::Strokes, render::StrokePoint;

constexpr double longestPiece = 0.5;            // pixels
constexpr std::uint32_t mostPieces = 1U << 17;  // of one way: what is longer leaves the picture

class LinePlaces {
  public:
    LinePlaces(const PictureSize& size, std::vector<SightPlace>& places) : size_(size), places_(places) {}

    void add(const StrokePoint& point) {
        const auto pixel = pixelOf({point.x, point.y}, size_);
        places_.push_back({pixel.y * size_.width + pixel.x, point.depth});
    }

  private:
    PictureSize size_;
    std::vector<SightPlace>& places_;
};

}  // namespace

std::uint32_t piecesBetween(const StrokePoint& from, const StrokePoint& to) {
    const double length = std::hypot(double{to.x} - from.x, double{to.y} - from.y);
    return static_cast<std::uint32_t>(
        std::clamp(std::ceil(length / longestPiece), 1.0, static_cast<double>(mostPieces)));
}

StrokePoint pointBetween(const StrokePoint& from, const StrokePoint& to, double share) {
    const auto mixed = [share](float a, float b) { return static_cast<float>(a + share * (b - a)); };
    return {mixed(from.x, to.x), mixed(from.y, to.y), mixed(from.width, to.width),
            from.depth + share * (to.depth - from.depth)};
}

PixelBox boxOf(const Strokes& strokes, const render::InkArea& area, const PictureSize& size) {
    constexpr double far = std::numeric_limits<double>::max();
    glm::dvec2 low(far), high(-far);
    for (auto i = area.begin; i < area.end; ++i) {
        for (auto k = strokes.outlines[i].begin; k < strokes.outlines[i].end; ++k) {
            const glm::dvec2 at(strokes.points[k].x, strokes.points[k].y);
            low = glm::min(low, at);
            high = glm::max(high, at);
        }
    }
    if (!(low.x < high.x) || !(low.y < high.y) || high.x <= 0.0 || high.y <= 0.0 || low.x >= size.width ||
        low.y >= size.height)
        return {};
    const auto first = pixelOf(low, size), last = pixelOf(high, size);
    return {first.x, first.y, last.x + 1, last.y + 1};
}

std::vector<SightPlace> placesOf(const render::Dots& dots, const PictureSize& size) {
    std::vector<SightPlace> places;
    for (const auto& dot : dots) {
        forCovered(dot, size, [&](std::uint32_t column, std::uint32_t row, float) {
            places.push_back({row * size.width + column, dot.depth});
        });
    }
    return places;
}

std::vector<SightPlace> placesOf(const Strokes& strokes, const PictureSize& size) {
    std::vector<SightPlace> places;
    LinePlaces lines(size, places);
    for (const auto& line : strokes.lines) {
        if (line.end == line.begin + 1) lines.add(strokes.points[line.begin]);
        for (auto i = line.begin + 1; i < line.end; ++i) {
            const auto &from = strokes.points[i - 1], &to = strokes.points[i];
            const auto pieces = piecesBetween(from, to);
            for (std::uint32_t k = 0; k < pieces; ++k) lines.add(pointBetween(from, to, (k + 0.5) / pieces));
        }
    }
    for (const auto& area : strokes.areas) {
        const auto box = boxOf(strokes, area, size);
        for (auto row = box.top; row < box.bottom; ++row) {
            for (auto column = box.left; column < box.right; ++column) {
                const float depth = strokes.areaDepths.at(column, row);
                if (depth != render::AreaDepths::none) places.push_back({row * size.width + column, depth});
            }
        }
    }
    return places;
}

}  // namespace mote::server
