// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/segments_cut.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "server/render/ink/normalised_cut.h"
#include "server/render/ink/region_graph.h"
#include "server/render/ink/segment_regions.h"
#include "server/render/ink/segments_graph.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

constexpr double cells = 60.0;            // of the grid, about
constexpr double superpixelScale = 30.0;  // as for graphs
constexpr std::uint32_t mostSuperpixels = 1500;
constexpr std::size_t coarsest = 16;  // least regions that a superpixel may have to be as large as
constexpr double meltedFrom = 0.6;    // mean affinity across what is no boundary
constexpr double anyTurn = 4.0;       // radians: melts whatever the directions

/// A grid's cell of each pixel.
Segments gridOf(std::uint32_t width, std::uint32_t height) {
    const double side = std::max(1.0, std::sqrt(double{1.0} * width * height / cells));
    Segments made{Raster<std::uint32_t>(width, height), 0};
    const auto along = [side](std::uint32_t at) { return static_cast<std::uint32_t>(at / side); };
    const std::uint32_t columns = along(width) + 1;
    for (std::uint32_t row = 0; row < height; ++row) {
        for (std::uint32_t column = 0; column < width; ++column)
            made.label.at(column, row) = along(row) * columns + along(column);
    }
    made.count = columns * (along(height) + 1);
    return made;
}

/// Small ones join others, and larger ones too while there are very many.
Segments superpixelsOf(const Modalities& modalities, const PixelWeights& weights, std::size_t leastPixels,
                       const std::stop_token& stop) {
    const auto& depth = modalities.depth;
    const auto joined = joinedByWeight(weights, depth, superpixelScale, stop);
    auto made = intersected(joined, joined, gridOf(depth.width, depth.height), stop);
    for (std::size_t times = 1; times <= coarsest && !isStopped(stop); times *= 2) {
        made = withoutSmall(std::move(made), modalities, times * leastPixels, stop);
        if (made.count <= mostSuperpixels) break;
    }
    return made;
}

}  // namespace

Segments cutSegments(const Modalities& modalities, std::size_t leastPixels, const std::stop_token& stop) {
    const auto weights = stepWeights(modalities, {}, stop);
    auto made = superpixelsOf(modalities, weights, leastPixels, stop);
    if (isStopped(stop)) return made;
    const auto graph = regionGraphOf(made, weights, stop);
    if (isStopped(stop)) return made;
    const auto groups = normalisedCuts(graph, {}, stop);
    Merges merges(made.count);
    for (const auto& link : graph.links) {
        if (groups[link.a] == groups[link.b]) merges.merge(link.a, link.b);
    }
    renumber(made, merges, stop);
    return melted(std::move(made), modalities, weights, meltedFrom, anyTurn, stop);
}

}  // namespace mote::render
