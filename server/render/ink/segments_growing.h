// SPDX-License-Identifier: GPL-3.0-or-later
//
// Regions that grow from seeds, after the dissertation's section 2.3.6.1: in the order of rows, a pixel that
// has no region is the seed of one. Pure; deterministic on any number of threads.
#pragma once

#include <stop_token>

#include "server/render/ink/segments.h"

namespace mote::render {

struct GrowOptions {
    double grey = 0.12;   ///< by so much a pixel's grey may differ from its region's mean
    double angle = 0.6;   ///< likewise its direction, radians; directions have no sign
    double depth = 0.01;  ///< a step from pixel to pixel beyond the slope there, of the extent
    /// Regions with so much mean affinity across their boundary, by steps of grey, direction and depth, melt,
    double affinity = 0.7;
    double turn = 1.1;  ///< unless their mean directions are so far apart, radians
};

/// Seeded region growing: a pixel beside a region joins it where its value is near the region's mean (Adams
/// and Bischof 1994, Seeded Region Growing). It ends where its part does. Where nothing is seen, no region.
Segments growGrey(const Modalities& modalities, double most, const std::stop_token& stop);
/// The same of directions, by doubled angles.
Segments growAngle(const Modalities& modalities, double most, const std::stop_token& stop);
/// Regions that end where the depth's gradient changes by a step: smooth slopes are one.
Segments growDepth(const Modalities& modalities, double most, const std::stop_token& stop);

/// What is one region by each of the three.
Segments grownSegments(const Modalities& modalities, const GrowOptions& options, std::size_t leastPixels,
                       const std::stop_token& stop);

}  // namespace mote::render
