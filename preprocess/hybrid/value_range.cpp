// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/hybrid/value_range.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "preprocess/job.h"

namespace mote::prep {
namespace {

ValueRange rangeOf(std::span<const float> values) {
    ValueRange range;
    float least = std::numeric_limits<float>::infinity();
    float greatest = -least;
    for (const float value : values) {
        const bool finite = std::isfinite(value);
        range.invalid += finite ? 0 : 1;
        least = finite ? std::min(least, value) : least;
        greatest = finite ? std::max(greatest, value) : greatest;
    }
    range.finite = values.size() - range.invalid;
    if (range.finite > 0) {
        range.min = least;
        range.max = greatest;
    }
    return range;
}

/// Looked at apart, and no further than the first that is none.
bool areIntegers(std::span<const float> values) {
    return std::all_of(values.begin(), values.end(),
                       [](float value) { return !std::isfinite(value) || value == std::trunc(value); });
}

}  // namespace

ValueRange ValueRange::united(const ValueRange& other) const {
    ValueRange both = finite > 0 ? *this : other;
    if (finite > 0 && other.finite > 0) {
        both.min = std::min(min, other.min);
        both.max = std::max(max, other.max);
    }
    both.finite = finite + other.finite;
    both.invalid = invalid + other.invalid;
    both.integers = integers && other.integers;
    return both;
}

Result<ValueRange> findRange(VolumeSource& source, std::uint32_t z0, std::uint32_t z1, std::uint32_t together,
                             const std::function<bool()>& cancelled) {
    const std::size_t slice = source.shape().voxelsOfSlice();
    std::vector<float> values;
    ValueRange range;
    for (auto z = z0; z < z1; z += together) {
        if (cancelled()) return wasCancelled();
        const auto end = std::min(z1, z + together);
        values.resize(slice * (end - z));
        MOTE_RETURN_IF_ERROR(source.read(z, end, values));
        constexpr std::size_t grain = std::size_t{1} << 16;
        const bool integers = range.integers;
        const auto found = tbb::parallel_reduce(
            tbb::blocked_range<std::size_t>(0, values.size(), grain), ValueRange(),
            [&](const tbb::blocked_range<std::size_t>& part, const ValueRange& before) {
                const auto some = std::span<const float>(values).subspan(part.begin(), part.size());
                auto ofSome = rangeOf(some);
                ofSome.integers = integers && areIntegers(some);
                return before.united(ofSome);
            },
            [](const ValueRange& a, const ValueRange& b) { return a.united(b); });
        range = range.united(found);
    }
    return range;
}

void addToHistogram(std::span<const float> values, const ValueRange& range, ValueHistogram& histogram) {
    const auto least = static_cast<float>(range.min);
    // A span so small that its inverse is no float is none.
    const auto perUnit = static_cast<float>(static_cast<double>(histogram.size()) / range.span());
    const float scale = range.span() > 0.0 && std::isfinite(perUnit) ? perUnit : 0.0F;
    for (const float value : values) {
        const auto bin = static_cast<std::size_t>((value - least) * scale);
        ++histogram[std::min(bin, histogram.size() - 1)];
    }
}

}  // namespace mote::prep
