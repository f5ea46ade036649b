// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/stipple/dot_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "server/render/plan/in_turns.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

using Range = tbb::blocked_range<std::size_t>;

constexpr int blockSide = 16;  ///< pixels
constexpr int mostRings = 64;  ///< of blocks around a block, in which dots are looked for

/// Sums over the pixels that are one dot's, relative to the dot.
struct Sums {
    float mass = 0.0F, x = 0.0F, y = 0.0F, xx = 0.0F, xy = 0.0F, yy = 0.0F;
};
struct Part {
    std::uint32_t dot;
    Sums sums;
};

/// Dots by block, those outside in the block nearest to them.
class Blocks {
  public:
    Blocks(const PixelMap& wanted, std::span<const glm::vec2> dots)
        : columns_((static_cast<int>(wanted.width()) + blockSide - 1) / blockSide),
          rows_((static_cast<int>(wanted.height()) + blockSide - 1) / blockSide) {
        begin_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + 1, 0);
        for (const auto& dot : dots) ++begin_[blockOf(dot) + 1];
        std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
        auto next = begin_;
        dots_.resize(dots.size());
        for (std::size_t i = 0; i < dots.size(); ++i) {
            dots_[next[blockOf(dots[i])]++] = static_cast<std::uint32_t>(i);
        }
    }

    int columns() const { return columns_; }
    int rows() const { return rows_; }

    /// Calls `take` with each dot of the blocks that lie `ring` blocks from this one, inside the picture.
    template <class Take>
    void forRing(int column, int row, int ring, const Take& take) const {
        for (int y = std::max(row - ring, 0); y <= std::min(row + ring, rows_ - 1); ++y) {
            const bool whole = y == row - ring || y == row + ring;
            const int step = whole || ring == 0 ? 1 : 2 * ring;
            for (int x = column - ring; x <= column + ring; x += step) {
                if (x < 0 || x >= columns_) continue;
                const auto block = static_cast<std::size_t>(y * columns_ + x);
                for (auto i = begin_[block]; i < begin_[block + 1]; ++i) take(dots_[i]);
            }
        }
    }

  private:
    std::size_t blockOf(const glm::vec2& dot) const {
        const int x = std::clamp(static_cast<int>(dot.x) / blockSide, 0, columns_ - 1);
        const int y = std::clamp(static_cast<int>(dot.y) / blockSide, 0, rows_ - 1);
        return static_cast<std::size_t>(y * columns_ + x);
    }

    int columns_;
    int rows_;
    std::vector<std::uint32_t> begin_;
    std::vector<std::uint32_t> dots_;
};

/// The dots that may be the nearest of some pixel of a block: none is, that is further from all of the block
/// than another is from its farthest corner.
class Nearby {
  public:
    Nearby(std::span<const glm::vec2> dots, const Blocks& blocks) : dots_(dots), blocks_(blocks) {}

    const std::vector<std::uint32_t>& find(int column, int row) {
        reach_ = std::numeric_limits<float>::max();
        found_.clear();
        left_ = static_cast<float>(column * blockSide);
        top_ = static_cast<float>(row * blockSide);
        for (int ring = 0; ring <= mostRings; ++ring) {
            // A dot in this ring is at least so far from the block.
            const auto gap = static_cast<float>(std::max(ring - 1, 0) * blockSide);
            if (gap * gap > reach_) break;
            blocks_.forRing(column, row, ring, [&](std::uint32_t dot) { add(dot); });
        }
        indices_.clear();
        for (const auto& [dot, least] : found_) {
            if (least <= reach_) indices_.push_back(dot);
        }
        return indices_;
    }

  private:
    void add(std::uint32_t dot) {
        const auto [leastX, mostX] = span(dots_[dot].x - left_);
        const auto [leastY, mostY] = span(dots_[dot].y - top_);
        reach_ = std::min(reach_, mostX * mostX + mostY * mostY);
        found_.emplace_back(dot, leastX * leastX + leastY * leastY);
    }

    /// Least and greatest distance to the pixels' centres along one axis.
    static std::pair<float, float> span(float at) {
        constexpr float last = blockSide - 0.5F;
        return {std::max({0.5F - at, at - last, 0.0F}), std::max(at - 0.5F, last - at)};
    }

    std::span<const glm::vec2> dots_;
    const Blocks& blocks_;
    float left_ = 0.0F, top_ = 0.0F;
    float reach_ = 0.0F;  ///< square pixels
    std::vector<std::pair<std::uint32_t, float>> found_;
    std::vector<std::uint32_t> indices_;
};

/// Which of the places is nearest to each pixel of a row of a block. Compiled for vectors.
void nearestInRow(const std::vector<glm::vec2>& places, float x, float y,
                  std::array<int, blockSide>& nearest) {
    std::array<float, blockSide> best;
    best.fill(std::numeric_limits<float>::max());
    for (std::size_t k = 0; k < places.size(); ++k) {
        const float dx = x - places[k].x;
        const float dy = y - places[k].y;
        for (int i = 0; i < blockSide; ++i) {
            const float along = dx + static_cast<float>(i);
            const float distance = along * along + dy * dy;
            const bool nearer = distance < best[i];
            best[i] = nearer ? distance : best[i];
            nearest[i] = nearer ? static_cast<int>(k) : nearest[i];
        }
    }
}

void addBlock(const PixelMap& wanted, std::span<const glm::vec2> dots, int column, int row, Nearby& nearby,
              std::vector<Part>& parts) {
    const auto& indices = nearby.find(column, row);
    if (indices.empty()) return;
    std::vector<glm::vec2> places;
    for (const auto index : indices) places.push_back(dots[index]);
    std::vector<Sums> sums(indices.size());
    const int firstX = column * blockSide;
    const int count = std::min(blockSide, static_cast<int>(wanted.width()) - firstX);
    const int lastY = std::min((row + 1) * blockSide, static_cast<int>(wanted.height()));
    std::array<int, blockSide> nearest{};
    for (int y = row * blockSide; y < lastY; ++y) {
        nearestInRow(places, static_cast<float>(firstX) + 0.5F, static_cast<float>(y) + 0.5F, nearest);
        const float* density = &wanted.row(static_cast<std::size_t>(y))[static_cast<std::size_t>(firstX)];
        for (int i = 0; i < count; ++i) {
            const auto k = static_cast<std::size_t>(nearest[i]);
            const float mass = density[i];
            const float dx = static_cast<float>(firstX + i) + 0.5F - places[k].x;
            const float dy = static_cast<float>(y) + 0.5F - places[k].y;
            auto& sum = sums[k];
            sum.mass += mass;
            sum.x += mass * dx;
            sum.y += mass * dy;
            sum.xx += mass * dx * dx;
            sum.xy += mass * dx * dy;
            sum.yy += mass * dy * dy;
        }
    }
    for (std::size_t k = 0; k < sums.size(); ++k) {
        if (sums[k].mass > 0.0F) parts.push_back({indices[k], sums[k]});
    }
}

}  // namespace

std::vector<DotCell> dotCells(const PixelMap& wanted, std::span<const glm::vec2> dots) {
    const Blocks blocks(wanted, dots);
    std::vector<std::vector<Part>> rows(static_cast<std::size_t>(blocks.rows()));
    forRangesInTurns(rows.size(), 1, [&](const Range& range) {
        Nearby nearby(dots, blocks);
        for (auto row = range.begin(); row != range.end(); ++row) {
            for (int column = 0; column < blocks.columns(); ++column) {
                addBlock(wanted, dots, column, static_cast<int>(row), nearby, rows[row]);
            }
        }
    });
    // In the order of the blocks, so that sums do not depend on threads.
    std::vector<DotCell> cells(dots.size());
    for (const auto& parts : rows) {
        giveWay();
        for (const auto& [dot, sums] : parts) {
            auto& cell = cells[dot];
            cell.mass += sums.mass;
            cell.centroid += glm::dvec2(sums.x, sums.y);
            cell.xx += sums.xx;
            cell.xy += sums.xy;
            cell.yy += sums.yy;
        }
    }
    for (std::size_t i = 0; i < cells.size(); ++i) {
        auto& cell = cells[i];
        const double share = cell.mass > 0.0 ? 1.0 / cell.mass : 0.0;
        const auto middle = cell.centroid * share;
        cell.xx = cell.xx * share - middle.x * middle.x;
        cell.xy = cell.xy * share - middle.x * middle.y;
        cell.yy = cell.yy * share - middle.y * middle.y;
        cell.centroid = glm::dvec2(dots[i]) + middle;
    }
    return cells;
}

}  // namespace mote::render
