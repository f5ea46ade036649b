// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/bounds_rule.h"

#include <fmt/format.h>
#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace mote::prep {
namespace {

constexpr std::size_t sampleSize = 65536;
constexpr double reach = 1000.0;

/// Of a sorted sample, linear between neighbours.
double quantile(const std::vector<double>& sorted, double share) {
    const double at = share * static_cast<double>(sorted.size() - 1);
    const auto below = static_cast<std::size_t>(at);
    const auto above = std::min(below + 1, sorted.size() - 1);
    // Not a + (b - a) f: the difference of two finite numbers may not be finite.
    const double f = at - static_cast<double>(below);
    return sorted[below] * (1.0 - f) + sorted[above] * f;
}

/// Where values are taken for particles of the beam.
Range accepted(const std::vector<double>& sorted) {
    const double median = quantile(sorted, 0.5);
    for (const double tail : {0.25, 0.05, 0.01}) {
        const double spread = quantile(sorted, 1.0 - tail) - quantile(sorted, tail);
        if (spread > 0.0) return {median - reach * spread, median + reach * spread};
    }
    return {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
}

std::vector<double> sortedSample(std::span<const double> values) {
    const std::size_t stride = (values.size() + sampleSize - 1) / sampleSize;
    std::vector<double> sample;
    for (std::size_t i = 0; i < values.size(); i += stride) sample.push_back(values[i]);
    std::sort(sample.begin(), sample.end());
    return sample;
}

}  // namespace

Range Range::united(const Range& other) const {
    if (empty()) return other;
    if (other.empty()) return *this;
    return {std::min(min, other.min), std::max(max, other.max)};
}

Range robustRange(std::span<const double> values) {
    if (values.empty()) return {};
    const Range inside = accepted(sortedSample(values));
    return tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, values.size(), 1 << 15), Range{},
        [&](const tbb::blocked_range<std::size_t>& part, Range range) {
            for (std::size_t i = part.begin(); i < part.end(); ++i) {
                const double value = values[i];
                if (value >= inside.min && value <= inside.max) range = range.united({value, value});
            }
            return range;
        },
        [](const Range& a, const Range& b) { return a.united(b); });
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
