// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/vector/ink_outline.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace mote::server {
namespace {

using render::StrokePoint;

constexpr double sharp = 0.5;       ///< cosine of a bend
constexpr double roundFrom = 0.75;  ///< half widths of ends that are more than a point; pixels

glm::dvec2 placeOf(const StrokePoint& point) {
    return {point.x, point.y};
}

glm::dvec2 leftOf(const glm::dvec2& way) {
    return {way.y, -way.x};
}

/// Half a circle around an end, from one side of the line to the other, its ends left out.
void addEnd(const StrokePoint& end, const glm::dvec2& outwards, std::vector<glm::dvec2>& path) {
    const double half = 0.5 * end.width;
    const int parts = half < roundFrom ? 2 : 4 + static_cast<int>(std::min(half, 32.0));
    for (int i = 1; i < parts; ++i) {
        const double angle = i * std::numbers::pi / parts;
        path.push_back(placeOf(end) +
                       half * (std::cos(angle) * leftOf(outwards) + std::sin(angle) * outwards));
    }
}

}  // namespace

/// From the point before, of length 1.
glm::dvec2 InkOutline::wayTo(std::size_t index) const {
    return glm::normalize(placeOf(points_[index]) - placeOf(points_[index - 1]));
}

bool InkOutline::bendsTo(const StrokePoint& point) const {
    if (points_.size() < 2 || placeOf(point) == placeOf(last())) return false;
    const glm::dvec2 way = glm::normalize(placeOf(point) - placeOf(last()));
    return glm::dot(way, wayTo(points_.size() - 1)) < sharp;
}

void InkOutline::add(const StrokePoint& point) {
    if (points_.empty() || placeOf(point) != placeOf(last())) points_.push_back(point);
}

void InkOutline::finish(PagePaths& outlines) {
    std::vector<glm::dvec2> path, back;
    const std::size_t count = points_.size();
    for (std::size_t i = 0; i < count && count > 1; ++i) {
        const glm::dvec2 way =
            glm::normalize(wayTo(std::max<std::size_t>(i, 1)) + wayTo(std::min(i + 1, count - 1)));
        const glm::dvec2 side = 0.5 * points_[i].width * leftOf(way);
        path.push_back(placeOf(points_[i]) + side);
        back.push_back(placeOf(points_[i]) - side);
    }
    if (count > 1) {
        addEnd(points_.back(), wayTo(count - 1), path);
        path.insert(path.end(), back.rbegin(), back.rend());
        addEnd(points_.front(), -wayTo(1), path);
        outlines.add(path);
    }
    points_.clear();
}

}  // namespace mote::server
