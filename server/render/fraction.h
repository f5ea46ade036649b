// SPDX-License-Identifier: GPL-3.0-or-later
//
// How many points of a leaf are drawn: part of the definition of the picture. A pure function.
#pragma once

#include <cmath>
#include <cstdint>

namespace mote::render {

/// The number of points, counted from a leaf's first, that a fraction in [0, 1] draws: floor(fraction * count
/// + u), with u in [0, 1) fixed for each leaf by a hash of its cell. So a leaf of one particle is drawn with
/// probability `fraction`, the sum over leaves is right on average, and growing fractions only ever add
/// points.
inline std::uint32_t drawnPoints(double fraction, std::uint32_t count, std::uint8_t level,
                                 std::uint64_t morton) {
    // splitmix64 (Steele, Lea, Flood 2014): full avalanche, so neighbours are unrelated.
    std::uint64_t h = morton ^ (std::uint64_t{level} << 58);
    h += 0x9e3779b97f4a7c15ULL;
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ULL;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebULL;
    h ^= h >> 31;
    const double u = static_cast<double>(h >> 40) * 0x1p-24;
    const double wanted = std::floor(fraction * count + u);
    return wanted >= count ? count : static_cast<std::uint32_t>(wanted);
}

}  // namespace mote::render
