// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/numbers/bin_kernel.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "storage/numbers/range_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "storage/numbers/bin_kernel.cpp"  // NOLINT
#include <hwy/foreach_target.h>                              // Must come before highway.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace mote::storage::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Bins = FloatBins::Guess;

/// The bins of as many values as whole vectors hold; those that are in doubt, near an edge, are left to
/// `settle`.
template <class Settle>
HWY_INLINE std::size_t guess(const float* values, std::size_t count, const Bins& bins, std::uint32_t* out,
                             const Settle& settle) {
    const hn::ScalableTag<float> floats;
    const hn::RebindToSigned<decltype(floats)> ints;
    const std::size_t lanes = hn::Lanes(floats);
    const auto first = hn::Set(floats, bins.first), last = hn::Set(floats, bins.last);
    const auto low = hn::Set(floats, bins.low), scale = hn::Set(floats, bins.scale);
    const auto doubt = hn::Set(floats, bins.doubt), sure = hn::Set(floats, 1.0F - bins.doubt);
    const auto none = hn::Set(ints, static_cast<std::int32_t>(bins.bins));
    std::size_t i = 0;
    for (; i + lanes <= count; i += lanes) {
        const auto value = hn::LoadU(floats, values + i);
        const auto within = hn::And(hn::Ge(value, first), hn::Le(value, last));
        const auto place = hn::Mul(hn::Sub(value, low), scale);
        const auto whole = hn::Floor(place);
        const auto rest = hn::Sub(place, whole);
        const auto clear = hn::And(hn::Ge(rest, doubt), hn::Le(rest, sure));
        const auto bin = hn::ConvertTo(ints, hn::IfThenElseZero(within, whole));
        hn::StoreU(hn::IfThenElse(hn::RebindMask(ints, within), bin, none), ints,
                   reinterpret_cast<std::int32_t*>(out + i));
        if (!hn::AllFalse(floats, hn::AndNot(clear, within))) settle(i, lanes);
    }
    return i;
}

void findBins(const float* values, std::size_t count, const Bins& bins, const float* begins,
              std::uint32_t* out) {
    // A guess is off by one bin at most. Values lie in a mapped file and may have changed since the guess.
    const auto settle = [&](std::size_t from, std::size_t lanes) {
        for (std::size_t k = from; k < from + lanes; ++k) {
            const float value = values[k];
            const auto last = static_cast<std::int32_t>(bins.bins) - 1;
            auto bin = std::clamp(static_cast<std::int32_t>(out[k]), 0, last);
            if (value < begins[bin])
                --bin;
            else if (value >= begins[bin + 1])
                ++bin;
            const bool within = value >= bins.first && value <= bins.last;
            out[k] = within ? static_cast<std::uint32_t>(std::clamp(bin, 0, last)) : bins.bins;
        }
    };
    guess(values, count, bins, out, settle);
}

}  // namespace mote::storage::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace mote::storage {
namespace {

HWY_EXPORT(findBins);

constexpr float mostDoubt = 0.25F;  // beyond it all values are looked up

}  // namespace

FloatBins::FloatBins(double offset, std::span<const double> edges) {
    constexpr double infinite = std::numeric_limits<double>::infinity();
    const std::size_t bins = edges.size() - 1;
    for (std::size_t i = 0; i < bins; ++i) begins_.push_back(floatRange(offset, edges[i], infinite).first);
    const auto all = floatRange(offset, edges.front(), edges.back());
    guess_.first = all.first;
    guess_.last = all.last;
    guess_.bins = static_cast<std::uint32_t>(bins);
    // Beyond any float of the last bin.
    begins_.push_back(std::nextafter(guess_.last, std::numeric_limits<float>::infinity()));
    guess_.low = static_cast<float>(edges.front() - offset);
    const double scale = static_cast<double>(bins) / (edges.back() - edges.front());
    guess_.scale = static_cast<float>(scale);
    // Half a unit in the last place of each operation and constant, of a value of the range and of a place.
    const double reach = std::max(std::abs(edges.front() - offset), std::abs(edges.back() - offset));
    const double off = 0x1p-22 * (reach * scale + static_cast<double>(bins)) +
                       0x1p-50 * std::max(std::abs(edges.front()), std::abs(edges.back())) * scale;
    guess_.doubt = std::isfinite(guess_.scale) && off < mostDoubt ? static_cast<float>(off) : 1.0F;
}

void FloatBins::find(std::span<const float> values, std::span<std::uint32_t> out) const {
    std::size_t done = 0;
    if (guess_.doubt <= mostDoubt) {
        // Whole vectors of any width.
        done = values.size() / 64 * 64;
        HWY_DYNAMIC_DISPATCH(findBins)
        (values.data(), done, guess_, begins_.data(), out.data());
    }
    for (std::size_t i = done; i < values.size(); ++i) {
        const float value = values[i];
        if (!(value >= guess_.first && value <= guess_.last)) {
            out[i] = guess_.bins;
            continue;
        }
        const auto after = std::upper_bound(begins_.begin() + 1, begins_.end() - 1, value);
        out[i] = static_cast<std::uint32_t>(after - begins_.begin()) - 1;
    }
}

}  // namespace mote::storage
#endif
