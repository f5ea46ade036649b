// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/segments.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "server/render/ink/normalised_cut.h"
#include "server/render/ink/region_graph.h"
#include "server/render/ink/segment_regions.h"
#include "server/render/ink/segments_graph.h"
#include "server/render/ink/segments_growing.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

// Regions of one texture, after Malik, Belongie, Leung and Shi 2001, Contour and Texture Analysis for Image
// Segmentation. Pure; deterministic on any number of threads.

constexpr double windowShare = 1.5;        // of the side of the least region: the window's standard deviation
constexpr double rough = 5.0;              // times the steps around that are no boundary
constexpr double joinScale = 30.0;         // pixels by which a weight of 1 is overcome
constexpr double textureMeltedFrom = 0.8;  // mean affinity across what is no boundary
constexpr double anyTextureTurn = 4.0;     // radians: melts whatever the directions

/// The graph's regions (segments_graph.h) by steps that stand out: of grey and direction, a step counts as
/// far as it is greater than several times the mean of steps in a window of about one and a half sides of the
/// least region, within a surface. So edges count little where there are many, as in the paper's gating by
/// texturedness. What has little of a boundary left then melts.
Segments textureSegments(const Modalities& modalities, std::size_t leastPixels, const std::stop_token& stop) {
    const double side = std::sqrt(static_cast<double>(std::max<std::size_t>(leastPixels, 1)));
    const auto roughness = roughnessOf(modalities, windowShare * side, stop);
    const auto weights = stepWeights(modalities, {}, stop, &roughness, rough);
    auto made = joinedByWeight(weights, modalities.depth, joinScale, stop);
    made = withoutSmall(std::move(made), modalities, leastPixels, stop);
    return melted(std::move(made), modalities, weights, textureMeltedFrom, anyTextureTurn, stop);
}

// Regions by normalised cuts (Shi and Malik 2000, Normalized Cuts and Image Segmentation) between
// superpixels. Pure; deterministic on any number of threads.

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

/// Superpixels are regions of the graph of pixels within cells of a grid, each with the sum of affinities
/// inside and to its neighbours: a cut between them costs what it costs between their pixels. The picture
/// is cut in two, and each side again, by the best of cuts along the first eigenvectors whose pairs of pixels
/// have little affinity in the mean.
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

Segments partedBy(const Modalities& modalities, const SegmentOptions& options, const std::stop_token& stop) {
    switch (options.method) {
        case Segmentation::graph:
            return graphSegments(modalities, options.leastPixels, stop);
        case Segmentation::cut:
            return cutSegments(modalities, options.leastPixels, stop);
        case Segmentation::texture:
            return textureSegments(modalities, options.leastPixels, stop);
        default:
            return grownSegments(modalities, {}, options.leastPixels, stop);
    }
}

}  // namespace

Segments segmentsOf(const Modalities& modalities, const SegmentOptions& options,
                    const std::stop_token& stop) {
    auto made = partedBy(modalities, options, stop);
    if (!isStopped(stop)) return made;
    // What was left half done may have labels above its count.
    return {Raster<std::uint32_t>(modalities.depth.width, modalities.depth.height, Segments::nothing), 0};
}

}  // namespace mote::render
