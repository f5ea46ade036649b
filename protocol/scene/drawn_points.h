// SPDX-License-Identifier: GPL-3.0-or-later
//
// How many points of a leaf are drawn, and from which fraction on each of them is: part of the definition of
// the picture. Pure functions.
#pragma once

#include <cmath>
#include <cstdint>

namespace mote {

/// A leaf's u in [0, 1), a multiple of 2^-24: fixed by a hash of its cell.
inline double leafOffset(std::uint8_t level, std::uint64_t morton) {
    // splitmix64 (Steele, Lea, Flood 2014): full avalanche, so neighbours are unrelated.
    std::uint64_t h = morton ^ (std::uint64_t{level} << 58);
    h += 0x9e3779b97f4a7c15ULL;
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ULL;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebULL;
    h ^= h >> 31;
    return static_cast<double>(h >> 40) * 0x1p-24;
}

/// The number of points, counted from a leaf's first, that a fraction in [0, 1] draws: floor(fraction * count
/// + u). So a leaf of one particle is drawn with probability `fraction`, the sum over leaves is right on
/// average, and growing fractions only ever add points.
inline std::uint32_t drawnPoints(double fraction, std::uint32_t count, std::uint8_t level,
                                 std::uint64_t morton) {
    const double wanted = std::floor(fraction * count + leafOffset(level, morton));
    return wanted >= count ? count : static_cast<std::uint32_t>(wanted);
}

/// The least fraction, in (0, 1], that draws point `place` of a leaf's `count` (but for the rounding of
/// drawnPoints): (place + 1 - u) / count.
inline double drawnFrom(std::uint32_t place, std::uint32_t count, double offset) {
    return (place + 1.0 - offset) / count;
}

}  // namespace mote
