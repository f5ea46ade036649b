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

/// How far it is, in blocks, to where something begins or ceases to be seen.
class VisibleBlocks {
  public:
    VisibleBlocks(const BlockRanges& ranges, const VolumeTable& table);

    bool any() const { return any_; }
    std::uint32_t edgeBits() const { return edgeBits_; }
    std::uint32_t side() const { return side_; }

    static constexpr std::uint8_t visible = 128;
    static constexpr std::uint8_t farthest = 127;
    /// Of each block, x fastest, and three bytes more, so that four can be read from each: the steps,
    /// diagonal ones included and at most `farthest`, to the next block in which something can be seen; in a
    /// block in which something can be seen itself, `visible` and the steps to the next in which nothing can.
    const std::uint8_t* steps() const { return steps_.data(); }

  private:
    std::uint32_t edgeBits_;
    std::uint32_t side_;
    bool any_ = false;
    std::vector<std::uint8_t> steps_;
};

}  // namespace mote::render
