// SPDX-License-Identifier: GPL-3.0-or-later
//
// Merges: numbers of which some become one (union-find by path halving: Tarjan and van Leeuwen 1984,
// Worst-case Analysis of Set Union Algorithms). A value.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "server/render/plan/long_list.h"

namespace mote::render {

/// Each number stands for the least of those that it has become one with.
class Merges {
  public:
    explicit Merges(std::uint32_t count) {
        parents_.reserve(count);
        for (std::uint32_t number = 0; number < count; ++number) {
            if (number % longListStep<std::uint32_t> == 0) giveWay();
            parents_.push_back(number);
        }
    }
    std::uint32_t root(std::uint32_t number) {
        while (parents_[number] != number) number = parents_[number] = parents_[parents_[number]];
        return number;
    }
    void merge(std::uint32_t a, std::uint32_t b) {
        a = root(a);
        b = root(b);
        parents_[std::max(a, b)] = std::min(a, b);
    }

  private:
    std::vector<std::uint32_t> parents_;
};

}  // namespace mote::render
