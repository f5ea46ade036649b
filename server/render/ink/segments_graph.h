// SPDX-License-Identifier: GPL-3.0-or-later
//
// Regions of a graph of pixels (Felzenszwalb and Huttenlocher 2004, Efficient Graph-Based Image
// Segmentation). Pure; deterministic on any number of threads.
#pragma once

#include <cstddef>
#include <stop_token>

#include "server/render/ink/region_graph.h"
#include "server/render/ink/segments.h"

namespace mote::render {

/// Pairs in the order of their weights, then of rows: two regions join where the weight is at most either's
/// greatest weight inside plus `scale` by its pixels. Regions of pixels where nothing is seen have no label.
Segments joinedByWeight(const PixelWeights& weights, const Raster<float>& depth, double scale,
                        const std::stop_token& stop);

/// Joins by steps in grey, direction and depth, without small ones.
Segments graphSegments(const Modalities& modalities, std::size_t leastPixels, const std::stop_token& stop);

}  // namespace mote::render
