// SPDX-License-Identifier: GPL-3.0-or-later
//
// What ways to part a picture into regions share: labels that become one, intersections, small regions that
// become part of their neighbours. Pure; deterministic.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <stop_token>
#include <utility>
#include <vector>

#include "server/render/ink/segments.h"

namespace mote::render {

/// Labels that become one: the least of them.
class Merges {
  public:
    explicit Merges(std::uint32_t count) : parents_(count) {
        std::iota(parents_.begin(), parents_.end(), 0U);
    }
    std::uint32_t root(std::uint32_t label) {
        while (parents_[label] != label) label = parents_[label] = parents_[parents_[label]];
        return label;
    }
    void merge(std::uint32_t a, std::uint32_t b) {
        a = root(a);
        b = root(b);
        parents_[std::max(a, b)] = std::min(a, b);
    }

  private:
    std::vector<std::uint32_t> parents_;
};

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
