// SPDX-License-Identifier: GPL-3.0-or-later
//
// Regions by normalised cuts (Shi and Malik 2000, Normalized Cuts and Image Segmentation) between
// superpixels. Pure; deterministic on any number of threads.
#pragma once

#include <cstddef>
#include <stop_token>

#include "server/render/ink/segments.h"

namespace mote::render {

/// Superpixels are regions of the graph of pixels within cells of a grid, each with the sum of affinities
/// inside and to its neighbours: a cut between them costs what it costs between their pixels. The picture
/// is cut in two, and each side again, by the best of cuts along the first eigenvectors whose pairs of pixels
/// have little affinity in the mean.
Segments cutSegments(const Modalities& modalities, std::size_t leastPixels, const std::stop_token& stop);

}  // namespace mote::render
