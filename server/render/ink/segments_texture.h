// SPDX-License-Identifier: GPL-3.0-or-later
//
// Regions of one texture, after Malik, Belongie, Leung and Shi 2001, Contour and Texture Analysis for Image
// Segmentation. Pure; deterministic on any number of threads.
#pragma once

#include <cstddef>
#include <stop_token>

#include "server/render/ink/segments.h"

namespace mote::render {

/// What filters of grey (edges along four directions) and of direction say is averaged over a window of
/// about `leastPixels` on either side of each pair of pixels; where the windows differ, and where depth
/// steps, is a boundary of the graph (segments_graph.h).
Segments textureSegments(const Modalities& modalities, std::size_t leastPixels, const std::stop_token& stop);

}  // namespace mote::render
