// SPDX-License-Identifier: GPL-3.0-or-later
//
// Segments: a picture parted into regions that are drawn with one kind of stroke (the dissertation's sections
// 2.3.1 and 2.3.6.1). Pure; deterministic on any number of threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stop_token>

#include "server/render/ink/modalities.h"

namespace mote::render {

struct Segments {
    static constexpr std::uint32_t nothing = UINT32_MAX;

    Raster<std::uint32_t> label;  ///< below `count`; `nothing` where nothing is seen
    std::uint32_t count = 0;
};

struct SegmentOptions {
    double grey = 0.12;   ///< by so much a pixel's grey may differ from its region's mean
    double angle = 0.6;   ///< likewise its direction, radians; directions have no sign
    double depth = 0.01;  ///< a step from pixel to pixel beyond the slope there, of the extent
    std::size_t leastPixels = 36;
};

/// Seeded region growing: seeds in the order of rows; a pixel beside a region joins it where its value is
/// near the region's mean (Adams and Bischof 1994, Seeded Region Growing). Where nothing is seen, no region.
Segments growGrey(const Modalities& modalities, double most);
/// The same of directions, by doubled angles.
Segments growAngle(const Modalities& modalities, double most);
/// Regions that end where the depth's gradient changes by a step: smooth slopes are one.
Segments growDepth(const Modalities& modalities, double most);
/// Connected pixels that each have one label in all of them.
Segments intersected(const Segments& a, const Segments& b, const Segments& c);
/// Regions of fewer pixels become part of the neighbour that is most like them, until there are none but
/// islands.
Segments withoutSmall(Segments segments, const Modalities& modalities, std::size_t leastPixels);

/// All of it.
Segments segmentsOf(const Modalities& modalities, const SegmentOptions& options, const std::stop_token& stop);

}  // namespace mote::render
