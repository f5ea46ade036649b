// SPDX-License-Identifier: GPL-3.0-or-later
//
// What of a volume each rank of a job works on: slices of its grids. Pure functions.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "preprocess/hybrid/volume_plan.h"

namespace mote::prep {

/// Slices [begin, end).
struct SliceRange {
    std::uint32_t begin = 0, end = 0;
};

struct RankPart {
    SliceRange low;     ///< of the low-resolution volume
    SliceRange source;  ///< those that lie in these cells of it; filtering them reads more
    SliceRange error;   ///< of the error grid, whole layers of bricks of points
};

/// The part of `rank` of `ranks`; those of all ranks cover each grid once. May be empty.
inline RankPart partOf(const VolumePlan& plan, int rank, int ranks) {
    const auto share = [&](std::uint32_t all, int of) {
        return static_cast<std::uint32_t>(std::uint64_t{all} * static_cast<std::uint64_t>(of) /
                                          static_cast<std::uint64_t>(ranks));
    };
    const auto cell = [&](std::uint32_t low) {
        const double slices = static_cast<double>(plan.source[2]) / plan.low[2];
        return static_cast<std::uint32_t>(std::lround(low * slices));
    };
    constexpr auto side = storage::pointBrickSide;
    const auto layers = storage::bricksOf(plan.error, side)[2];
    const auto slice = [&](std::uint32_t layer) { return std::min(plan.error[2], layer * side); };
    RankPart part;
    part.low = {share(plan.low[2], rank), share(plan.low[2], rank + 1)};
    part.source = {cell(part.low.begin), cell(part.low.end)};
    part.error = {slice(share(layers, rank)), slice(share(layers, rank + 1))};
    return part;
}

}  // namespace mote::prep
