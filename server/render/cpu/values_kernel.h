// SPDX-License-Identifier: GPL-3.0-or-later
//
// The inner loops over the values of points, compiled for each instruction set and chosen at run time. Pure
// functions on the memory they are given; any thread.
#pragma once

#include <bit>
#include <cstdint>

#include "server/render/cpu/points_kernel.h"
#include "server/render/plan/point_values.h"

namespace mote::render {

/// A pixel's points that have a value, from bit `countShift`, and the sum of their codes below.
using ValueSum = std::uint64_t;
inline constexpr unsigned countShift = 40;
/// No more points are added to sums before they are carried off: a pixel may hold them all.
inline constexpr std::uint64_t mostAdded = (std::uint64_t{1} << 24) - 1;

/// Adds each point of a run in view that has a value to its pixel, sums[y * width + x], behind which there
/// are spareCounts more. `codes`: of the first leaf's points; the others follow.
void addValues(const PointMap& map, const LeafRun& run, const ValueCode* codes, ValueSum* sums);

/// A depth and a code: of two points the one with the lesser key is nearer. None: all ones.
using NearKey = std::uint64_t;
inline NearKey nearKey(float depth, ValueCode code) {
    const auto bits = std::bit_cast<std::uint32_t>(depth);
    const std::uint32_t ordered = bits >> 31 != 0 ? ~bits : bits | 0x80000000U;
    return NearKey{ordered} << 16 | code;
}

inline constexpr NearKey noKey = ~NearKey{0};
/// Of a key; not a number, which nothing is greater than, of none.
inline float depthOfKey(NearKey key) {
    const auto ordered = static_cast<std::uint32_t>(key >> 16);
    return std::bit_cast<float>(ordered >> 31 != 0 ? ordered & 0x7fffffffU : ~ordered);
}

/// The same of the least key of each pixel's points; depths are slabs before bends. `counts`: null, or as
/// countPoints, of which it returns what that does, else 0.
std::uint64_t addNearest(const PointMap& map, const LeafRun& run, const ValueCode* codes, NearKey* keys,
                         FullCount full, std::uint32_t* counts);

/// Every point of one leaf on the screen, in order; `slab` is before bends. One that is nearer than what is
/// seen lies far outside.
void projectEach(const PointMap& map, LeafCell cell, const storage::PackedPosition* points, std::size_t count,
                 const storage::PackedPosition* end, ScreenPoint* out);

}  // namespace mote::render
