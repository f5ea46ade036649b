// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/segments_texture.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/render/ink/region_graph.h"
#include "server/render/ink/segment_regions.h"
#include "server/render/ink/segments_graph.h"

namespace mote::render {
namespace {

constexpr double windowShare = 1.5;        // of the side of the least region: the window's standard deviation
constexpr double rough = 5.0;              // times the steps around that are no boundary
constexpr double joinScale = 30.0;         // pixels by which a weight of 1 is overcome
constexpr double textureMeltedFrom = 0.8;  // mean affinity across what is no boundary
constexpr double anyTextureTurn = 4.0;     // radians: melts whatever the directions

}  // namespace

Segments textureSegments(const Modalities& modalities, std::size_t leastPixels, const std::stop_token& stop) {
    const double side = std::sqrt(static_cast<double>(std::max<std::size_t>(leastPixels, 1)));
    const auto roughness = roughnessOf(modalities, windowShare * side, stop);
    const auto weights = stepWeights(modalities, {}, stop, &roughness, rough);
    auto made = joinedByWeight(weights, modalities.depth, joinScale, stop);
    made = withoutSmall(std::move(made), modalities, leastPixels, stop);
    return melted(std::move(made), modalities, weights, textureMeltedFrom, anyTextureTurn, stop);
}

}  // namespace mote::render
