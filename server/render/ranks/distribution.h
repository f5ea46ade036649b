// SPDX-License-Identifier: GPL-3.0-or-later
//
// How the leaves of a step are distributed to ranks: runs of leaves that follow each other in the file, to
// each rank in turn. A run lies together on the disk, so a rank reads and keeps little but its own points;
// and since the file ascends in density, each rank has its share of halo and core, whatever is selected. Pure
// functions.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/render/cpu/tile.h"

namespace mote::render {

class LeafDistribution {
  public:
    LeafDistribution(std::size_t leaves, int ranks);

    std::size_t run() const { return std::size_t{1} << shift_; }  ///< leaves
    int owner(std::size_t leaf) const {
        return static_cast<int>((leaf >> shift_) % static_cast<std::size_t>(ranks_));
    }

    /// A bit a leaf for the first `count`, as leavesInView(): those of `inView` that belong to `rank`. If
    /// `inView` has no bits, all are in view.
    std::vector<std::uint64_t> own(const std::vector<std::uint64_t>& inView, std::size_t count,
                                   int rank) const;

  private:
    int ranks_;
    unsigned shift_;
};

/// How the tiles of a picture are distributed to ranks, each in turn, and drawn in batches, so that the cells
/// that ranks send each other are bounded at any size of the picture, and between which it may give way; a
/// batch has a tile for each rank at
/// least. A value; pure functions.
struct TileDistribution {
    /// The most that a rank's cells for all others take, if every cell holds points.
    static constexpr std::size_t batchBytes = std::size_t{256} << 20;

    /// A rank draws no more before a picture may give way: some milliseconds of a volume.
    static constexpr std::size_t mostOfARank = 256;

    std::uint32_t columns, tiles;  ///< of the picture
    std::uint32_t batch;           ///< tiles drawn at a time
    std::uint32_t ranks;

    TileDistribution(std::uint32_t width, std::uint32_t height, std::size_t tileBytes, int rankCount)
        : columns(tilesAcross(width)),
          tiles(columns * tilesAcross(height)),
          ranks(static_cast<std::uint32_t>(rankCount)) {
        const std::size_t fits =
            std::min(tileBytes == 0 ? tiles : batchBytes / tileBytes, mostOfARank * ranks);
        batch = static_cast<std::uint32_t>(std::clamp<std::size_t>(fits, std::min(ranks, tiles), tiles));
    }

    std::uint32_t owner(std::uint32_t tile) const { return tile % ranks; }
    /// The first tile of a rank that is not before `tile`; the next one is `ranks` further.
    std::uint32_t firstOf(std::uint32_t rank, std::uint32_t tile) const {
        return tile + (rank + ranks - tile % ranks) % ranks;
    }
    /// How many tiles of a rank lie in [begin, end).
    std::uint32_t countOf(std::uint32_t rank, std::uint32_t begin, std::uint32_t end) const {
        const std::uint32_t first = firstOf(rank, begin);
        return first < end ? (end - first - 1) / ranks + 1 : 0;
    }
    Tile at(std::uint32_t tile) const { return {tile % columns, tile / columns}; }
};

}  // namespace mote::render
