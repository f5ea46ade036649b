// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/numbers/range_kernel.h"

#include <bit>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "storage/numbers/range_kernel.cpp"  // NOLINT
#include <hwy/foreach_target.h>                                // Must come before highway.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace mote::storage::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

void keepInRange(const float* values, std::size_t count, FloatRange range, std::uint64_t* words) {
    const hn::CappedTag<float, 64> floats;
    const std::size_t lanes = hn::Lanes(floats);
    const auto first = hn::Set(floats, range.first), last = hn::Set(floats, range.last);
    std::size_t i = 0;
    for (; i + 64 <= count; i += 64) {
        std::uint64_t word = 0;
        if (words[i / 64] == 0) continue;
        for (std::size_t k = 0; k < 64; k += lanes) {
            const auto value = hn::LoadU(floats, values + i + k);
            const auto within = hn::And(hn::Ge(value, first), hn::Le(value, last));
            std::uint64_t bits = 0;
            hn::StoreMaskBits(floats, within, reinterpret_cast<std::uint8_t*>(&bits));
            word |= (bits & (lanes == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << lanes) - 1)) << k;
        }
        words[i / 64] &= word;
    }
    if (i == count) return;
    std::uint64_t word = 0;
    for (std::size_t k = 0; i + k < count; ++k)
        word |= std::uint64_t{values[i + k] >= range.first && values[i + k] <= range.last} << k;
    words[i / 64] &= word;
}

void findWithin(const double* values, std::size_t count, double low, double end, std::uint64_t* words) {
    const hn::CappedTag<double, 64> doubles;
    const std::size_t lanes = hn::Lanes(doubles);
    const auto first = hn::Set(doubles, low), beyond = hn::Set(doubles, end);
    std::size_t i = 0;
    for (; i < count; i += 64) {
        std::uint64_t word = 0;
        std::size_t k = 0;
        for (; k < 64 && i + k + lanes <= count; k += lanes) {
            const auto value = hn::LoadU(doubles, values + i + k);
            const auto without = hn::Or(hn::Lt(value, first), hn::Ge(value, beyond));
            std::uint64_t bits = 0;
            hn::StoreMaskBits(doubles, without, reinterpret_cast<std::uint8_t*>(&bits));
            word |= (~bits & ((std::uint64_t{1} << lanes) - 1)) << k;
        }
        for (; k < 64 && i + k < count; ++k)
            word |= std::uint64_t{!(values[i + k] < low) && !(values[i + k] >= end)} << k;
        words[i / 64] = word;
    }
}

}  // namespace mote::storage::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace mote::storage {
namespace {

HWY_EXPORT(findWithin);
HWY_EXPORT(keepInRange);

/// Floats but NaN in their order, from minus infinity.
constexpr std::int64_t ofInfinity = 0x7F800000;
float floatAt(std::int64_t place) {
    const auto bits = static_cast<std::uint32_t>(place < 0 ? -place - 1 : place);
    const float magnitude = std::bit_cast<float>(bits);
    return place < 0 ? -magnitude : magnitude;
}

/// The first place in [-ofInfinity - 1, ofInfinity + 1] at which `reached`, which stays true, is true.
template <class Reached>
std::int64_t firstPlace(const Reached& reached) {
    std::int64_t low = -ofInfinity - 1, high = ofInfinity + 1;
    while (low < high) {
        const auto middle = low + (high - low) / 2;
        if (reached(floatAt(middle)))
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

}  // namespace

FloatRange floatRange(double offset, double low, double high) {
    const auto value = [&](float f) { return offset + static_cast<double>(f); };
    const auto first = firstPlace([&](float f) { return value(f) >= low; });
    const auto beyond = firstPlace([&](float f) { return value(f) > high; });
    constexpr float infinite = std::numeric_limits<float>::infinity();
    if (first >= beyond) return {infinite, -infinite};
    return {floatAt(first), floatAt(beyond - 1)};
}

void findWithin(std::span<const double> values, double low, double end, std::span<std::uint64_t> words) {
    HWY_DYNAMIC_DISPATCH(findWithin)(values.data(), values.size(), low, end, words.data());
}

void keepInRange(std::span<const float> values, FloatRange range, std::span<std::uint64_t> words) {
    HWY_DYNAMIC_DISPATCH(keepInRange)(values.data(), values.size(), range, words.data());
}

}  // namespace mote::storage
#endif
