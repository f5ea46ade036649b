// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/numbers/chosen_kernel.h"

#include <bit>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "storage/numbers/chosen_kernel.cpp"  // NOLINT
#include <hwy/foreach_target.h>                                 // Must come before highway.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace mote::storage::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, roomBehindChosen>;

/// Some values as they are stored become doubles.
struct FromFloats {
    using Tag = hn::Rebind<float, Doubles>;
    const float* values;
    double zero;

    auto load(std::size_t i) const { return hn::LoadU(Tag(), values + i); }
    template <class V>
    void store(V some, double* out) const {
        const Doubles doubles;
        hn::StoreU(hn::Add(hn::PromoteTo(doubles, some), hn::Set(doubles, zero)), doubles, out);
    }
    double at(std::size_t i) const { return zero + static_cast<double>(values[i]); }
};

struct FromDoubles {
    using Tag = Doubles;
    const double* values;

    auto load(std::size_t i) const { return hn::LoadU(Tag(), values + i); }
    template <class V>
    void store(V some, double* out) const {
        hn::StoreU(some, Doubles(), out);
    }
    double at(std::size_t i) const { return values[i]; }
};

template <class From>
std::size_t copyFrom(const From& from, std::size_t count, const std::uint64_t* words, double* out) {
    const typename From::Tag tag;
    const std::size_t lanes = hn::Lanes(tag);
    const std::uint64_t all = (std::uint64_t{1} << lanes) - 1;
    auto* next = out;
    std::size_t i = 0;
    for (; i + 64 <= count; i += 64) {
        const auto word = words[i / 64];
        if (word == 0) continue;
        for (std::size_t k = 0; k < 64; k += lanes) {
            const std::uint64_t bits = word >> k & all;
            // Where neighbours are chosen together there is mostly nothing to pack.
            auto some = from.load(i + k);
            if (bits != all) {
                const auto* const byte = reinterpret_cast<const std::uint8_t*>(&bits);
                some = hn::Compress(some, hn::LoadMaskBits(tag, byte));
            }
            from.store(some, next);
            next += std::popcount(bits);
        }
    }
    for (std::size_t k = 0; i + k < count; ++k) {
        if ((words[i / 64] >> k & 1U) != 0) *next++ = from.at(i + k);
    }
    return static_cast<std::size_t>(next - out);
}

std::size_t copyFloats(const float* values, std::size_t count, double zero, const std::uint64_t* words,
                       double* out) {
    return copyFrom(FromFloats{values, zero}, count, words, out);
}

std::size_t copyDoubles(const double* values, std::size_t count, const std::uint64_t* words, double* out) {
    return copyFrom(FromDoubles{values}, count, words, out);
}

}  // namespace mote::storage::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace mote::storage {
namespace {

HWY_EXPORT(copyFloats);
HWY_EXPORT(copyDoubles);

}  // namespace

std::size_t copyChosen(std::span<const float> values, double zero, std::span<const std::uint64_t> words,
                       double* out) {
    return HWY_DYNAMIC_DISPATCH(copyFloats)(values.data(), values.size(), zero, words.data(), out);
}

std::size_t copyChosen(std::span<const double> values, std::span<const std::uint64_t> words, double* out) {
    return HWY_DYNAMIC_DISPATCH(copyDoubles)(values.data(), values.size(), words.data(), out);
}

}  // namespace mote::storage
#endif
