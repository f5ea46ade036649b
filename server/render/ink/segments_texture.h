// SPDX-License-Identifier: GPL-3.0-or-later
//
// Regions of one texture, after Malik, Belongie, Leung and Shi 2001, Contour and Texture Analysis for Image
// Segmentation. Pure; deterministic on any number of threads.
#pragma once

#include <cstddef>
#include <stop_token>

#include "server/render/ink/segments.h"

namespace mote::render {

/// The graph's regions (segments_graph.h) by steps that stand out: of grey and direction, a step counts as
/// far as it is greater than several times the mean of steps in a window of about one and a half sides of the
/// least region, within a surface. So edges count little where there are many, as in the paper's gating by
/// texturedness. What has little of a boundary left then melts.
Segments textureSegments(const Modalities& modalities, std::size_t leastPixels, const std::stop_token& stop);

}  // namespace mote::render
