// SPDX-License-Identifier: GPL-3.0-or-later
//
// How the leaves of a step are distributed to ranks: runs of leaves that follow each other in the file, to
// each rank in turn. A run lies together on the disk, so a rank reads and keeps little but its own points;
// and since the file ascends in density, each rank has its share of halo and core, whatever is selected. Pure
// functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace mote::render {

class LeafDistribution {
  public:
    LeafDistribution(std::size_t leaves, int ranks);

    std::size_t run() const { return std::size_t{1} << shift_; }  ///< leaves
    int owner(std::size_t leaf) const {
        return static_cast<int>((leaf >> shift_) % static_cast<std::size_t>(ranks_));
    }

    /// A bit a leaf for the first `count`, as leavesInView(): those of `inView` that belong to `rank`. Where
    /// `inView` has no bits, all are in view.
    std::vector<std::uint64_t> own(const std::vector<std::uint64_t>& inView, std::size_t count,
                                   int rank) const;

  private:
    int ranks_;
    unsigned shift_;
};

}  // namespace mote::render
