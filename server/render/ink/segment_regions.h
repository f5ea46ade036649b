// SPDX-License-Identifier: GPL-3.0-or-later
//
// What ways to part a picture into regions share: labels that become one, intersections, small regions that
// become part of their neighbours. Pure; deterministic.
#pragma once

#include <cstdint>
#include <stop_token>

#include "server/render/ink/merges.h"
#include "server/render/ink/segments.h"

namespace mote::render {

/// Labels of merged regions, from 0 on, in the order of their first pixels.
void renumber(Segments& segments, Merges& merges, const std::stop_token& stop);

/// Connected pixels that each have one label in all of them.
Segments intersected(const Segments& a, const Segments& b, const Segments& c, const std::stop_token& stop);

/// Regions of fewer pixels become part of the neighbour that is most like them in grey, angle and depth,
/// until there are none but islands. One that has a pixel beside another region's of the same part goes to
/// such a one: so they cross from part to part only where all that is seen of one there is small.
Segments withoutSmall(Segments segments, const Modalities& modalities, std::size_t leastPixels,
                      const std::stop_token& stop);

}  // namespace mote::render
