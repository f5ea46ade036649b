// SPDX-License-Identifier: GPL-3.0-or-later
//
// Where a volume can be seen, block of cells by block, so that rays skip the rest: BlockRanges belongs to a
// volume, VisibleBlocks to a volume and a transfer function. Immutable once made; safe on any number of
// threads.
//
// Block b covers the padded places (packed_volume.h) [b, b + 1) * edge.
#pragma once

#include <cstdint>
#include <vector>

#include "server/render/cpu/packed_volume.h"
#include "server/render/cpu/volume_table.h"

namespace mote::render {

/// The range of t that interpolation meets in each block.
class BlockRanges {
  public:
    explicit BlockRanges(const PackedVolume& volume);

    struct Range {
        float low, high;  ///< t
    };
    std::uint32_t edgeBits() const { return edgeBits_; }          ///< a block's edge is 1 << edgeBits cells
    std::uint32_t side() const { return side_; }                  ///< blocks
    const std::vector<Range>& ranges() const { return ranges_; }  ///< x fastest

  private:
    std::uint32_t edgeBits_;
    std::uint32_t side_;
    std::vector<Range> ranges_;
};

/// How far the next block is in which something can be seen.
class VisibleBlocks {
  public:
    VisibleBlocks(const BlockRanges& ranges, const VolumeTable& table);

    bool any() const { return any_; }
    std::uint32_t edgeBits() const { return edgeBits_; }
    std::uint32_t side() const { return side_; }
    /// x fastest, and three bytes more, so that four can be read from each: 0 where something can be seen,
    /// else the steps, diagonal ones included, to the next block in which it can, at most `farthest`.
    const std::uint8_t* distances() const { return distances_.data(); }
    static constexpr std::uint8_t farthest = 255;

  private:
    void spread(int direction);

    std::uint32_t edgeBits_;
    std::uint32_t side_;
    bool any_ = false;
    std::vector<std::uint8_t> distances_;
};

}  // namespace mote::render
