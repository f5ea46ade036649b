// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which values of a column as it is stored lie in a range. Pure functions, vectorised for the processor at
// hand, with the same result on all.
#pragma once

#include <cstdint>
#include <span>

namespace mote::storage {

/// Both ends belong to it; empty where first > last.
struct FloatRange {
    float first, last;
};

/// The floats f for which low <= offset + f <= high in doubles.
FloatRange floatRange(double offset, double low, double high);

/// Sets in `words`, a bit a value, those that are neither below `low` nor `end` or beyond it: also NaN. Bits
/// beyond the last value are 0.
void findWithin(std::span<const double> values, double low, double end, std::span<std::uint64_t> words);

/// Takes those out of `words`, a bit a value, that do not lie in the range; a NaN lies in none.
void keepInRange(std::span<const float> values, FloatRange range, std::span<std::uint64_t> words);

}  // namespace mote::storage
