// SPDX-License-Identifier: GPL-3.0-or-later
//
// Conversion of numbers to integers that hold them. Compiled once for each target (Highway's foreach_target),
// hence without #pragma once.
#if defined(MOTE_TRUNCATED_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_TRUNCATED_INL_H
#undef MOTE_TRUNCATED_INL_H
#else
#define MOTE_TRUNCATED_INL_H
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {

/// ConvertTo of what an integer holds; of what it does not, anything.
template <class D>
HWY_INLINE auto truncated(D /*d*/, hwy::HWY_NAMESPACE::Vec<D> values) {
    namespace hn = hwy::HWY_NAMESPACE;
    using Integers = hn::RebindToSigned<D>;
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX3
    if constexpr (hn::MaxLanes(D()) == 16) return hn::Vec<Integers>{_mm512_cvttps_epi32(values.raw)};
#elif HWY_TARGET == HWY_AVX2
    if constexpr (hn::MaxLanes(D()) == 8) return hn::Vec<Integers>{_mm256_cvttps_epi32(values.raw)};
#endif
    return hn::ConvertTo(Integers(), values);
}

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
