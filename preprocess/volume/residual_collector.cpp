// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/residual_collector.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace mote::prep {
namespace {

constexpr std::uint32_t side = storage::residualBrickSide;

/// Whether any sample of the brick is corrected.
bool fill(const ErrorSlab& slab, const ErrorSelection& selection, double step, CollectedBrick& brick) {
    storage::GridSize end{};
    for (std::size_t a = 0; a < 3; ++a) end[a] = std::min(slab.grid[a], (brick.index[a] + 1) * side);
    bool any = false;
    for (auto z = brick.index[2] * side; z < end[2]; ++z) {
        for (auto y = brick.index[1] * side; y < end[1]; ++y) {
            const auto* errors = slab.error(z) + std::size_t{y} * slab.grid[0];
            for (auto x = brick.index[0] * side; x < end[0]; ++x) {
                if (!selection.takes(errors[x])) continue;
                const auto multiple = static_cast<std::int32_t>(std::floor(errors[x] / step + 0.5));
                brick.multiples[x % side + side * (y % side) + side * side * (z % side)] = multiple;
                any = any || multiple != 0;
            }
        }
    }
    return any;
}

}  // namespace

double residualStep(const ValueRange& range, double threshold) {
    const double span = range.span() > 0.0 ? range.span() : 1.0;
    const double quantum = range.integers ? 1.0 : std::exp2(std::floor(std::log2(span)) - 16.0);
    if (2.0 * threshold <= quantum) return quantum;
    return std::exp2(std::floor(std::log2(2.0 * threshold)));
}

std::vector<CollectedBrick> residualBricks(const ErrorSlab& slab, const ErrorSelection& selection,
                                           double step) {
    const auto counts = storage::bricksOf(slab.grid, side);
    const auto first = slab.z0 / side;
    const auto layers = (slab.z1 - slab.z0 + side - 1) / side;
    std::vector<std::vector<CollectedBrick>> rows(std::size_t{layers} * counts[1]);
    tbb::parallel_for(std::size_t{0}, rows.size(), [&](std::size_t row) {
        const auto by = static_cast<std::uint32_t>(row % counts[1]);
        const auto bz = static_cast<std::uint32_t>(row / counts[1]);
        CollectedBrick brick;
        for (std::uint32_t bx = 0; bx < counts[0]; ++bx) {
            brick.index = {bx, by, first + bz};
            if (!fill(slab, selection, step, brick)) continue;
            rows[row].push_back(brick);
            brick.multiples = {};
        }
    });
    std::vector<CollectedBrick> bricks;
    for (auto& row : rows) std::move(row.begin(), row.end(), std::back_inserter(bricks));
    return bricks;
}

}  // namespace mote::prep
