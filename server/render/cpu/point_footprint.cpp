// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/point_footprint.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "server/render/cpu/tile.h"

namespace mote::render {
namespace {

// More points than these take longer to be sorted than to be added up, and among so many the order of two is
// seen in few pixels.
constexpr std::uint64_t mostPoints = 1 << 14;
constexpr std::size_t mostLeaves = 1 << 16;  // that are looked at for them
constexpr double mostHits = 1 << 19;         // of a layer in a tile, in memory at a time
// Points that are all but clear hide none of each other: they are mixed, but for a few.
constexpr std::uint64_t mostClear = 1 << 10;
constexpr double clear = 1.0 / 64.0;

/// Of a whole point, in the pixel that it covers most; of one that is lit, at the depth that is looked at.
float mostOf(const FramePlan& plan, const PointLook& look) {
    if (look.light == 0.0) return thinnedOpacity(pointFootprint(look).most, look.thinned);
    const double depth = glm::length(plan.camera.target - plan.camera.eye);
    return static_cast<float>(-std::expm1(-look.thinned * look.tauAt(depth, plan.camera.perspective())));
}

/// The most hits of points that all lie in one tile; where some are opaque those behind are left out.
double hitsInTile(const FramePlan& plan, const PointsPlan& layer) {
    constexpr double opaque = 10.0;  // optical depth
    const double across = std::max(layer.look.size, 0.0) + 2.0;
    const double pixels = std::min<double>({Tile::pixels, double(plan.width) * plan.height, across * across});
    const double depth = -std::log1p(-mostOf(plan, layer.look));
    return pixels * std::min(static_cast<double>(layer.pointsDrawn), 1.0 + opaque / std::max(depth, 1e-9));
}

}  // namespace

bool standAlone(const FramePlan& plan, const PointsPlan& layer) {
    if (!plan.exact || layer.preview != nullptr) return false;
    if (layer.pointsDrawn > mostPoints || layer.selection->drawn.size() > mostLeaves) return false;
    if (layer.pointsDrawn > mostClear && mostOf(plan, layer.look) < clear) return false;
    return hitsInTile(plan, layer) <= mostHits;
}

bool shadesCells(const FramePlan& plan, const PointsPlan& points) {
    return points.colors && points.colors->shade && !standAlone(plan, points);
}

DotFootprint pointFootprint(const PointLook& look) {
    const auto size = static_cast<float>(look.size);
    const auto opacity = look.light > 0.0 ? 1.0F : static_cast<float>(look.opacity);
    if (size > 1.0F) return {0.5F * size + 0.5F, opacity};
    return {0.0F, look.light > 0.0 ? 1.0F : size * size * opacity};
}

DiscFootprint::DiscFootprint(double size, double opacity)
    : reach_(static_cast<float>(0.5 * size + 0.5)),
      opacity_(static_cast<float>(std::max(opacity, 0.0))),
      ofLogarithm_(opacity > 0.0 ? static_cast<float>(1.0 / std::log1p(-opacity)) : 0.0F) {
    // A pixel of coverage c has the opacity c * opacity: its optical depth is not in proportion.
    for (std::uint32_t i = 0; i <= steps; ++i) {
        const double coverage = static_cast<double>(i) / steps;
        const double share =
            !(opacity > 0.0) ? coverage : std::log1p(-opacity * coverage) / std::log1p(-opacity);
        weight_[i] = static_cast<float>(share);
    }
}

}  // namespace mote::render
