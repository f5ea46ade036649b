// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/segments_texture.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "server/render/ink/region_graph.h"
#include "server/render/ink/segment_regions.h"
#include "server/render/ink/segments_graph.h"

namespace mote::render {
namespace {

double env(const char* n, double d) {
    return std::getenv(n) ? std::atof(std::getenv(n)) : d;
}

const double joinScale = env("TJ", 30.0);
const double meltedFrom = env("TM", 0.6);
constexpr double anyTurn = 4.0;

}  // namespace

Segments textureSegments(const Modalities& modalities, std::size_t leastPixels, const std::stop_token& stop) {
    const double side = std::sqrt(static_cast<double>(std::max<std::size_t>(leastPixels, 1)));
    const auto roughness = roughnessOf(modalities, env("TS", 0.8) * side, stop);
    const auto weights = stepWeights(modalities, {}, stop, &roughness, env("TR", 3.0));
    auto made = joinedByWeight(weights, modalities.depth, joinScale, stop);
    made = withoutSmall(std::move(made), modalities, leastPixels, stop);
    return melted(std::move(made), modalities, weights, meltedFrom, anyTurn, stop);
}

}  // namespace mote::render
