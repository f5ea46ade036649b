// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/classified_bricks.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "server/render/egl/frame_block.h"

namespace mote::render {
namespace {

constexpr unsigned longerShift = 21, stepsShift = 24;
constexpr unsigned mostLonger = 3;  // powers of two
// Optical depth of a segment, at most, that is longer than usual: what is taken as even in it is a part of
// that, and differs by less.
constexpr double thin = 0.01;

/// What extinction can reach between two values.
class Extinctions {
  public:
    explicit Extinctions(const TransferTable& table)
        : table_(table), change_(TransferTable::cells + 2, 0.0F) {
        for (std::size_t i = 1; i < change_.size(); ++i)
            change_[i] = change_[i - 1] + std::abs(slope(i) - slope(i - 1));
    }
    /// Not less than any.
    double most(const BlockRanges::Range& range) const {
        const std::size_t first = place(range.low, std::floor), last = place(range.high, std::ceil);
        return double{slope(first)} + change_[last] - change_[first];
    }

  private:
    float slope(std::size_t i) const { return table_.entries()[i].mean(); }
    std::size_t place(double value, double (*rounded)(double)) const {
        const double x = 1.0 + (value - table_.low()) / (table_.high() - table_.low()) * TransferTable::cells;
        return static_cast<std::size_t>(std::clamp(rounded(x), 0.0, TransferTable::cells + 1.0));
    }

    const TransferTable& table_;
    std::vector<float> change_;  // sum of all changes before
};

double longestCell(const GridField& step, const glm::uvec3& grid) {
    double cell = 0.0;
    for (int axis = 0; axis < 3; ++axis)
        cell = std::max(cell, glm::length(glm::dvec3(step.boxToLayer[axis])) / grid[axis]);
    return cell;
}

/// The power of two by which a segment may be longer.
std::uint32_t longerBy(double depth) {
    const double times = thin / std::max(depth, 1e-9);
    return static_cast<std::uint32_t>(std::clamp(std::floor(std::log2(times)), 0.0, double{mostLonger}));
}

/// The words of a field of which nothing is seen.
std::vector<std::uint32_t> unseen(const glm::uvec3& grid) {
    const glm::uvec3 count = (grid + (GridBricks::edge - 1U)) / GridBricks::edge;
    return std::vector<std::uint32_t>(std::size_t{count.x} * count.y * count.z,
                                      std::uint32_t{VisibleBlocks::farthest} << stepsShift);
}

}  // namespace

ClassifiedBricks::ClassifiedBricks(const CorrectedField& samples, const GridSight& seen)
    : table(tableEntries(*seen.table)) {
    const GridField& step = *samples.grid;
    const GridBricks* const bricks = samples.corrected() ? step.bricks.get() : nullptr;
    const glm::uvec3& grid = bricks == nullptr ? step.coarse.size : bricks->size;
    if (seen.blocks == nullptr) {
        words = unseen(grid);
        return;
    }
    const Extinctions extinctions(*seen.table);
    const double low = longestCell(step, step.coarse.size) / GridBlock::lowSegments;
    const double fine = longestCell(step, grid) / GridBlock::fineSegments;
    const glm::uvec3& count = seen.blocks->count();
    const auto& ranges = seen.ranges->ranges();
    words.reserve(ranges.size());
    for (std::uint32_t i = 0; i < ranges.size(); ++i) {
        const std::uint32_t number =
            bricks == nullptr ? 0U : static_cast<std::uint32_t>(bricks->numbers[i] + 1);
        const std::uint32_t steps = seen.blocks->steps()[i];
        words.push_back(number | steps << stepsShift);
        if (steps < VisibleBlocks::visible) continue;
        words.back() |= longerBy(extinctions.most(ranges[i]) * (number > 0 ? fine : low)) << longerShift;
        visible.push_back(i % count.x | i / count.x % count.y << 10 | i / count.x / count.y << 20);
    }
}

}  // namespace mote::render
