// SPDX-License-Identifier: GPL-3.0-or-later
//
// VolumePlan: what a request for a hybrid volume comes to for a source of a given shape, which of its slices
// each rank works on, and how many at a time the memory allows. Values and pure functions, but for the
// machine's own size.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <optional>

#include "preprocess/volume/volume_source.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "storage/hybrid/hybrid_limits.h"

namespace mote::prep {

enum class LowFilter {
    cubic,  ///< Keys' cubic, stretched to the low-resolution volume's spacing
    box,    ///< the mean of the source over each sample's cell
    under,  ///< cubic, lowered until it overestimates no sample of the source by more than an allowance
};

struct VolumePlan {
    storage::GridSize source{}, low{}, error{};
    LowFilter filter = LowFilter::cubic;
    double allowance = 0.0;  ///< of `under`: a fraction of the range of values
    double threshold = 0.0;  ///< least error that counts, a fraction of the range of values; or:
    std::optional<std::uint64_t> maxPoints;  ///< the samples of greatest error
    std::uint32_t pointBytes = 0;            ///< 5, 6 or 9; 0: no points
    bool residual = false;
    std::uint32_t valueBits = 8;  ///< of a code of the low-resolution volume, 8 or 16
    glm::dmat4 indexToWorld{1.0};
};

/// What can be said of a request before its inputs are looked at. Errors: invalidArgument with the field's
/// path.
Status checkVolumeJob(const proto::VolumeJob& job);

/// `job` was checked. Errors: invalidArgument (6 bytes a point on a larger error grid), resourceExhausted
/// (grids larger than a dataset may have).
Result<VolumePlan> planVolume(const proto::VolumeJob& job, const VolumeShape& shape);

/// The map from indices of a grid over the source's box to the world.
glm::dmat4 gridToWorld(const VolumePlan& plan, const storage::GridSize& grid);

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

struct VolumeMemory {
    std::uint32_t slices = 0;  ///< of the source or the error grid, worked on at once
};

/// `limit` is this process', 0 for three quarters of the machine's memory; on `threads` threads. Errors:
/// resourceExhausted, if not even a few slices fit, with what is missing. What each takes:
/// docs/HYBRID_VOLUMES.md.
Result<VolumeMemory> planMemory(const VolumePlan& plan, std::uint64_t limit, int threads);

}  // namespace mote::prep
