// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/hybrid/residual_collector.h"

#include <oneapi/tbb/concurrent_vector.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "preprocess/on_threads.h"

namespace mote::prep {
namespace {

using storage::GridSize;

constexpr std::uint32_t side = storage::residualBrickSide;

/// A part of a node that one thread encodes: so wide along x, in bricks.
constexpr std::uint32_t partBricks = 4;

using Multiples = std::array<std::int32_t, storage::residualBrickSamples>;

/// Whether any sample of the brick with this index is corrected.
bool fill(const ErrorSlab& slab, const ErrorSelection& selection, double step, const GridSize& brick,
          Multiples& multiples) {
    GridSize end{};
    for (std::size_t a = 0; a < 3; ++a) end[a] = std::min(slab.grid[a], (brick[a] + 1) * side);
    bool any = false;
    for (auto z = brick[2] * side; z < end[2]; ++z) {
        for (auto y = brick[1] * side; y < end[1]; ++y) {
            const auto* errors = slab.error(z) + std::size_t{y} * slab.grid[0];
            for (auto x = brick[0] * side; x < end[0]; ++x) {
                if (!selection.takes(errors[x])) continue;
                const auto multiple = static_cast<std::int32_t>(std::floor(errors[x] / step + 0.5));
                multiples[x % side + side * (y % side) + side * side * (z % side)] = multiple;
                any = any || multiple != 0;
            }
        }
    }
    return any;
}

/// All bricks of the slab with indices from `begin` to `end` along x and y, which are in one node.
void encode(const ErrorSlab& slab, const ErrorSelection& selection, const GridSize& begin,
            const GridSize& end, double step, storage::ResidualEncoder& encoder) {
    Multiples multiples{};
    for (auto bx = begin[0]; bx < end[0]; ++bx) {
        for (auto by = begin[1]; by < end[1]; ++by) {
            for (auto bz = begin[2]; bz < end[2]; ++bz) {
                if (!fill(slab, selection, step, {bx, by, bz}, multiples)) continue;
                encoder.add({bx, by, bz}, multiples);
                multiples = {};
            }
        }
    }
}

}  // namespace

double residualStep(const ValueRange& range, double valueStep, double threshold) {
    const auto powerUpTo = [](double number) { return std::exp2(std::floor(std::log2(number))); };
    const double span = powerUpTo(range.span() > 0.0 ? range.span() : 1.0);
    const double known = valueStep > 0.0 ? powerUpTo(valueStep) : range.integers ? 1.0 : 0.0;
    const double quantum = known > 0.0 ? std::max(known, span * 0x1p-19) : span * 0x1p-16;
    return 2.0 * threshold <= quantum ? quantum : powerUpTo(2.0 * threshold);
}

Result<std::vector<storage::ResidualPart>> residualParts(const ErrorSlab& slab,
                                                         const ErrorSelection& selection,
                                                         const storage::ResidualCoding& coding,
                                                         storage::ScratchFile& scratch) {
    constexpr auto nodeSide = storage::residualNodeBricks;
    const auto bricks = storage::bricksOf(slab.grid, side);
    const auto first = slab.z0 / side;
    const auto last = (slab.z1 + side - 1) / side;
    MOTE_CHECK(slab.z0 % side == 0 && first / nodeSide == (last - 1) / nodeSide);
    const auto columns = (bricks[0] + partBricks - 1) / partBricks;
    const auto rows = (bricks[1] + nodeSide - 1) / nodeSide;
    FirstError failure;
    tbb::concurrent_vector<storage::ResidualPart> parts;
    tbb::parallel_for(0U, columns * rows, [&](std::uint32_t task) {
        const GridSize begin{task % columns * partBricks, task / columns * nodeSide, first};
        const GridSize end{std::min(bricks[0], begin[0] + partBricks),
                           std::min(bricks[1], begin[1] + nodeSide), last};
        storage::ResidualEncoder encoder(coding,
                                         {begin[0] / nodeSide, begin[1] / nodeSide, begin[2] / nodeSide});
        encode(slab, selection, begin, end, coding.step, encoder);
        const auto part = encoder.store(scratch);
        if (!part.ok()) return failure.set(part.error());
        if (*part) parts.push_back(**part);
    });
    MOTE_RETURN_IF_ERROR(failure.status());
    return std::vector<storage::ResidualPart>(parts.begin(), parts.end());
}

}  // namespace mote::prep
