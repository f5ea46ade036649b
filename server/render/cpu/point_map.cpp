// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/point_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/render/plan/screen_map.h"

namespace mote::render {
PointMap PointMap::make(const FramePlan& plan, const PointsPlan& layer) {
    constexpr double positionSteps = 65536.0;
    PointMap map{.edge = {},
                 .corner = {},
                 .step = {},
                 .width = plan.width,
                 .height = plan.height,
                 .bends = slabBends(plan, layer.boxToEye),
                 .perspective = plan.camera.perspective()};
    // A little less, for rounding at the very border of the box.
    if (map.perspective) map.nearest = static_cast<float>(plan.nearDepth * (1.0 - 1e-5));
    const glm::dmat4 toScreen = boxToScreen(plan, layer.boxToEye);
    for (std::size_t row = 0; row < rows; ++row) {
        const auto at = static_cast<int>(row);
        map.corner[row] = toScreen[3][at];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            map.edge[axis][row] = toScreen[static_cast<int>(axis)][at];
            for (unsigned level = 0; level <= deepestLeafLevel; ++level) {
                map.step[level][axis][row] = static_cast<float>(
                    std::ldexp(map.edge[axis][row] / positionSteps, -static_cast<int>(level)));
            }
        }
    }
    return map;
}

double PointMap::longestEdge() const {
    double nearestW = corner[rowW];
    for (const auto& side : edge) nearestW += std::min(side[rowW], 0.0);
    if (!(nearestW > 0.0)) return std::numeric_limits<double>::infinity();
    const double half = 0.5 * std::max(width, height);
    double longest = 0.0;
    for (const auto& side : edge) {
        const double along =
            std::max(std::abs(side[rowX]), std::abs(side[rowY])) + half * std::abs(side[rowW]);
        longest = std::max(longest, along / nearestW);
    }
    return longest;
}

}  // namespace mote::render
