// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/bounds_rule.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>

namespace mote::prep {
namespace {

constexpr std::uint64_t sampleSize = 65536;
constexpr double reach = 1000.0;

/// A quantile of a sorted sample, linear between neighbours.
double quantile(const std::vector<double>& sorted, double share) {
    const double at = share * static_cast<double>(sorted.size() - 1);
    const auto below = static_cast<std::size_t>(at);
    const auto above = std::min(below + 1, sorted.size() - 1);
    // Not a + (b - a) f: the difference of two finite numbers may not be finite.
    const double f = at - static_cast<double>(below);
    return sorted[below] * (1.0 - f) + sorted[above] * f;
}

}  // namespace

Range Range::united(const Range& other) const {
    if (empty()) return other;
    if (other.empty()) return *this;
    return {std::min(min, other.min), std::max(max, other.max)};
}

std::uint64_t sampleStride(std::uint64_t values) {
    return std::max<std::uint64_t>(1, (values + sampleSize - 1) / sampleSize);
}

Range acceptedRange(std::vector<double> sample) {
    const Range all{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    if (sample.empty()) return all;
    std::sort(sample.begin(), sample.end());
    const double median = quantile(sample, 0.5);
    for (const double tail : {0.25, 0.05, 0.01}) {
        const double spread = quantile(sample, 1.0 - tail) - quantile(sample, tail);
        if (spread > 0.0) return {median - reach * spread, median + reach * spread};
    }
    return all;
}

Result<Range> widened(Range range) {
    if (range.min == range.max) {
        const double value = range.min;
        const double half = value == 0.0 ? 1.0 : std::max(1e-3 * std::abs(value), 1e-300);
        range = {value - half, value + half};
    }
    if (std::isfinite(range.max - range.min)) return range;
    return Error{ErrorCode::resourceExhausted, "",
                 fmt::format("its values reach from {} to {}, too wide for a plot; give it bounds", range.min,
                             range.max)};
}

}  // namespace mote::prep
