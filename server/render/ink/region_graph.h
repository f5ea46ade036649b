// SPDX-License-Identifier: GPL-3.0-or-later
//
// RegionGraph: regions as nodes that stand for all their pixels, and how much of the graph of pixels
// (pixel_weights.h) lies within each and between two of them. Pure; deterministic.
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "server/render/ink/pixel_weights.h"
#include "server/render/ink/segments.h"

namespace mote::render {

struct RegionGraph {
    struct Link {
        std::uint32_t a, b;  ///< regions beside each other, a < b
        double affinity;     ///< summed over pairs of pixels, 0 to 1 each
        double length;       ///< pairs of pixels, above 0
    };

    std::vector<double> inside;  ///< affinity of each region's pixels among themselves, each pair twice
    std::vector<Link> links;     ///< each pair of regions once, in their order
};

/// Where `stop` is requested meanwhile, it lacks something.
RegionGraph regionGraphOf(const Segments& segments, const PixelWeights& weights, const std::stop_token& stop);

/// Melts boundaries that are none (Brice and Fennema 1970, Scene Analysis Using Regions): two regions become
/// one, those that belong together most first, where the mean affinity across their boundary is above `most`
/// and their mean directions are less than `turn` apart, radians.
Segments melted(Segments segments, const Modalities& modalities, const PixelWeights& weights, double most,
                double turn, const std::stop_token& stop);

}  // namespace mote::render
