// SPDX-License-Identifier: GPL-3.0-or-later
//
// These classes tell where a field can be seen, block of cells by block, so that rays skip the rest:
// BlockRanges belongs to a field, VisibleBlocks to a field and a transfer function. Immutable once made; safe
// on any number of threads.
//
// Block b covers the places [b, b + 1) * edge of the field's cells (of the cpu device's PackedVolume, padded
// ones).
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <utility>
#include <vector>

#include "server/render/plan/transfer_table.h"

namespace mote::render {

/// The range of values that interpolation meets in each block.
class BlockRanges {
  public:
    struct Range {
        float low, high;  ///< as the field's table takes them
    };

    /// `fine`: whether each block is to be walked in fine steps; empty: none is.
    BlockRanges(std::uint32_t edgeBits, const glm::uvec3& count, std::vector<Range> ranges,
                std::vector<std::uint8_t> fine)
        : edgeBits_(edgeBits), count_(count), ranges_(std::move(ranges)), fine_(std::move(fine)) {}

    std::uint32_t edgeBits() const { return edgeBits_; }          ///< a block's edge is 1 << edgeBits cells
    const glm::uvec3& count() const { return count_; }            ///< blocks along each axis
    const std::vector<Range>& ranges() const { return ranges_; }  ///< x fastest
    bool fine(std::size_t block) const { return !fine_.empty() && fine_[block] != 0; }

  private:
    std::uint32_t edgeBits_;
    glm::uvec3 count_;
    std::vector<Range> ranges_;
    std::vector<std::uint8_t> fine_;
};

/// How far it is, in blocks, to where something begins or ceases to be seen.
class VisibleBlocks {
  public:
    VisibleBlocks(const BlockRanges& ranges, const TransferTable& table);
    /// `seen`: whether anything is seen of such values.
    VisibleBlocks(const BlockRanges& ranges, const std::function<bool(const BlockRanges::Range&)>& seen);

    bool any() const { return any_; }
    bool anyFine() const { return anyFine_; }  ///< visible blocks
    std::uint32_t edgeBits() const { return edgeBits_; }
    const glm::uvec3& count() const { return count_; }

    static constexpr std::uint8_t visible = 64;  ///< something can be seen
    static constexpr std::uint8_t fine = 128;    ///< something can be seen, by fine steps
    static constexpr std::uint8_t farthest = 63;
    /// One byte a block, x fastest, and three more, so that four can be read from each: `visible`, `fine` or
    /// neither, and in the low bits the steps, diagonal ones included and at most `farthest`, to the next
    /// block of another kind.
    const std::uint8_t* steps() const { return steps_.data(); }

  private:
    std::uint32_t edgeBits_;
    glm::uvec3 count_;
    bool any_ = false, anyFine_ = false;
    std::vector<std::uint8_t> steps_;
};

}  // namespace mote::render
