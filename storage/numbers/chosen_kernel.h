// SPDX-License-Identifier: GPL-3.0-or-later
//
// Brings the values of chosen points together, as doubles, in their order. Pure functions, vectorised for the
// processor at hand, with the same result on all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace mote::storage {

/// So many doubles beyond the last may be written to.
inline constexpr std::size_t roomBehindChosen = 8;

/// Writes zero + value of those whose bit in `words` is set, and returns how many they are. There is a word
/// for each 64 values; bits beyond the last value are 0. `out` has room for them, and roomBehindChosen more.
std::size_t copyChosen(std::span<const float> values, double zero, std::span<const std::uint64_t> words,
                       double* out);
/// Writes the values themselves.
std::size_t copyChosen(std::span<const double> values, std::span<const std::uint64_t> words, double* out);

}  // namespace mote::storage
