// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/segments_cut.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "server/render/ink/normalised_cut.h"
#include "server/render/ink/segment_regions.h"
#include "server/render/ink/segments_graph.h"

namespace mote::render {
namespace {

constexpr double cells = 160.0;          // of the grid, about
constexpr double superpixelScale = 8.0;  // as for graphs
constexpr std::uint32_t mostSuperpixels = 1500;

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

/// Small ones join others, and ever larger ones until there are few enough.
Segments superpixelsOf(const Modalities& modalities, const PixelWeights& weights, std::size_t leastPixels,
                       const std::stop_token& stop) {
    const auto& depth = modalities.depth;
    const auto joined = joinedByWeight(weights, depth, superpixelScale, stop);
    auto made = intersected(joined, joined, gridOf(depth.width, depth.height), stop);
    for (std::size_t least = std::max<std::size_t>(leastPixels, 1);
         least <= depth.values.size() && !stop.stop_requested(); least *= 2) {
        made = withoutSmall(std::move(made), modalities, least, stop);
        if (made.count <= mostSuperpixels) break;
    }
    return made;
}

/// Superpixels beside each other.
struct Pair {
    std::uint32_t a, b;  // a < b
    double affinity;

    bool operator<(const Pair& other) const { return std::pair(a, b) < std::pair(other.a, other.b); }
};

CutGraph graphOf(const Segments& superpixels, const PixelWeights& weights, const std::stop_token& stop) {
    CutGraph graph;
    graph.inside.resize(superpixels.count);
    const auto& labels = superpixels.label.values;
    std::vector<Pair> pairs;
    for (std::size_t pair = 0; pair < weights.of.size(); ++pair) {
        if (pair % weights.width == 0 && stop.stop_requested()) return {};
        if (weights.of[pair] == PixelWeights::parted) continue;
        const auto a = labels[pair / 2], b = labels[weights.other(pair)];
        const double affinity = PixelWeights::affinity(weights.of[pair]);
        if (a == b)
            graph.inside[a] += 2.0 * affinity;
        else
            pairs.push_back({std::min(a, b), std::max(a, b), affinity});
    }
    std::stable_sort(pairs.begin(), pairs.end());
    for (const auto& pair : pairs) {
        if (graph.links.empty() || graph.links.back().a != pair.a || graph.links.back().b != pair.b)
            graph.links.push_back({pair.a, pair.b, 0.0, 0.0});
        graph.links.back().affinity += pair.affinity;
        graph.links.back().length += 1.0;
    }
    return graph;
}

}  // namespace

Segments cutSegments(const Modalities& modalities, std::size_t leastPixels, const std::stop_token& stop) {
    const auto weights = stepWeights(modalities, {}, stop);
    auto made = superpixelsOf(modalities, weights, leastPixels, stop);
    if (stop.stop_requested()) return made;
    const auto graph = graphOf(made, weights, stop);
    if (stop.stop_requested()) return made;
    const auto groups = normalisedCuts(graph, {}, stop);
    Merges merges(made.count);
    for (const auto& link : graph.links) {
        if (groups[link.a] == groups[link.b]) merges.merge(link.a, link.b);
    }
    renumber(made, merges, stop);
    return made;
}

}  // namespace mote::render
