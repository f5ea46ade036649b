// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/ink_line.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

namespace mote::render {
namespace {

constexpr double lineTolerance = 0.125;  // pixels that a line may be off its points
constexpr double alikeSteps = 0.02;      // of depth, extents
constexpr std::size_t longestRun = 32;   // points of which none is needed

double offLine(const LinePoint& point, const LinePoint& from, const LinePoint& to) {
    const glm::dvec2 way = to.at - from.at, off = point.at - from.at;
    const double square = glm::dot(way, way);
    const double share = square > 0.0 ? std::clamp(glm::dot(off, way) / square, 0.0, 1.0) : 0.0;
    return glm::distance(point.at, from.at + share * way);
}

}  // namespace

void simplify(std::vector<LinePoint>& points) {
    std::vector<LinePoint> kept{points.front()};
    std::size_t anchor = 0;
    for (std::size_t i = 1; i + 1 < points.size(); ++i) {
        bool needed =
            i + 1 - anchor > longestRun || std::abs(points[i].step - points[anchor].step) > alikeSteps;
        for (std::size_t k = anchor + 1; !needed && k <= i; ++k)
            needed = offLine(points[k], points[anchor], points[i + 1]) > lineTolerance;
        if (!needed) continue;
        kept.push_back(points[i]);
        anchor = i;
    }
    kept.push_back(points.back());
    points = std::move(kept);
}

}  // namespace mote::render
