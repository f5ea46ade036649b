// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/reference/stroke_hits.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <limits>

namespace mote::reference {
namespace {

using render::StrokePoint;

struct Place {
    double distance = std::numeric_limits<double>::infinity();  ///< pixels
    double width = 0.0, depth = 0.0;
};

Place placeOn(const StrokePoint& from, const StrokePoint& to, const glm::dvec2& pixel) {
    const glm::dvec2 a(from.x, from.y), way = glm::dvec2(to.x, to.y) - a;
    const double length2 = glm::dot(way, way);
    const double share = length2 > 0.0 ? std::clamp(glm::dot(pixel - a, way) / length2, 0.0, 1.0) : 0.0;
    return {glm::distance(pixel, a + share * way), (1.0 - share) * from.width + share * to.width,
            (1.0 - share) * from.depth + share * to.depth};
}

/// That [low, high] and [from, to] have in common.
double overlap(double low, double high, double from, double to) {
    return std::max(std::min(high, to) - std::max(low, from), 0.0);
}

}  // namespace

/// Through the middles of a pixel's sixteenths: the share of 16 lines that lies inside.
double StrokeHits::shareOf(const render::InkArea& area, std::uint32_t column, std::uint32_t row) const {
    double sum = 0.0;
    for (int line = 0; line < 16; ++line) {
        const double y = row + (line + 0.5) / 16.0;
        std::vector<double> crossings;
        for (auto i = area.begin; i < area.end; ++i) {
            const auto [begin, end] = strokes_.outlines[i];
            for (auto j = begin; j < end; ++j) {
                const StrokePoint& a = strokes_.points[j];
                const StrokePoint& b = strokes_.points[j + 1 == end ? begin : j + 1];
                if ((a.y <= y) == (b.y <= y)) continue;
                const double share = (y - a.y) / (double{b.y} - a.y);
                crossings.push_back((1.0 - share) * a.x + share * b.x);
            }
        }
        std::sort(crossings.begin(), crossings.end());
        for (std::size_t i = 0; i + 1 < crossings.size(); i += 2)
            sum += overlap(crossings[i], crossings[i + 1], column, column + 1.0);
    }
    return sum / 16.0;
}

/// Infinite where a pixel has none.
double StrokeHits::areaDepthAt(std::uint32_t column, std::uint32_t row) const {
    const auto& depths = strokes_.areaDepths;
    if (row >= depths.height || column >= depths.width) return std::numeric_limits<double>::infinity();
    return depths.values[row * std::size_t{depths.width} + column];
}

void StrokeHits::addPixel(std::uint32_t column, std::uint32_t row, std::vector<Hit>& hits) const {
    std::vector<Hit> here;
    const auto add = [&](double depth, double alpha) {
        if (alpha > 0.0 && depth >= nearestDepth(view_.camera))
            here.push_back({column, depth, std::min(alpha, 1.0), strokes_.color});
    };
    const glm::dvec2 middle(column + 0.5, row + 0.5);
    for (const auto& line : strokes_.lines) {
        Place nearest;
        for (auto i = line.begin; i < line.end; ++i) {
            const auto& to = strokes_.points[i + 1 < line.end ? i + 1 : i];
            const Place place = placeOn(strokes_.points[i], to, middle);
            if (place.distance < nearest.distance) nearest = place;
        }
        const double half = 0.5 * nearest.width;
        add(nearest.depth, overlap(-half, half, nearest.distance - 0.5, nearest.distance + 0.5));
    }
    const double depth = areaDepthAt(column, row);
    if (std::isfinite(depth)) {
        for (const auto& area : strokes_.areas) add(depth, shareOf(area, column, row));
    }
    fade(here);
    hits.insert(hits.end(), here.begin(), here.end());
}

/// What of them lies before any depth is as pale as all of it.
void StrokeHits::fade(std::vector<Hit>& hits) const {
    std::stable_sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) { return a.depth < b.depth; });
    const auto passed = [this](double left) { return 1.0 - strokes_.opacity * (1.0 - left); };
    double left = 1.0;
    for (auto& hit : hits) {
        const double behind = left * (1.0 - hit.alpha);
        if (strokes_.opacity < 1.0F) hit.alpha = 1.0 - passed(behind) / passed(left);
        left = behind;
    }
}

void StrokeHits::addRow(std::uint32_t row, std::vector<Hit>& hits) const {
    for (std::uint32_t column = 0; column < view_.width; ++column) addPixel(column, row, hits);
}

}  // namespace mote::reference
