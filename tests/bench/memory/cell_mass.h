// SPDX-License-Identifier: GPL-3.0-or-later
//
// CellMass: the share of a beam that lies in each cell of an octree: a narrow core in a wide halo, both
// normal distributions, cut to the plot's box. An immutable value; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace mote::bench {

class CellMass {
  public:
    explicit CellMass(unsigned deepestLevel);

    /// Of the cell in column, row and slice `at` of its level; the cells of a level sum to 1.
    double operator()(unsigned level, const std::array<std::uint32_t, 3>& at) const;

  private:
    struct Part {
        double share;
        double width;                    ///< standard deviation, the box' edge being 1
        std::vector<double> below = {};  ///< share of an axis below the i-th edge of the deepest cells
    };
    double along(const Part& part, unsigned level, std::uint32_t at) const;

    unsigned deepestLevel_;
    std::array<Part, 3> parts_{{{0.70, 0.02}, {0.25, 0.06}, {0.05, 0.16}}};
};

}  // namespace mote::bench
