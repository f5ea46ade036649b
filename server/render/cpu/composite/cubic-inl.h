// SPDX-License-Identifier: GPL-3.0-or-later
//
// Cubics along rays, a vector at a time. Compiled once for each target (Highway's foreach_target), hence
// without #pragma once.
#if defined(MOTE_CUBIC_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_CUBIC_INL_H
#undef MOTE_CUBIC_INL_H
#else
#define MOTE_CUBIC_INL_H
#endif

#include "server/render/cpu/composite/density_sample-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// ((c3 s + c2) s + c1) s + c0.
struct Cubic {
    V c0, c1, c2, c3;

    /// By what it is at 0, 1/3, 2/3 and 1.
    HWY_INLINE static Cubic through(V y0, V y1, V y2, V y3) {
        const Floats d;
        const V ends = hn::Sub(y3, y0), thirds = hn::Sub(y2, y1);
        const V c3 = hn::Mul(hn::Sub(ends, hn::Mul(thirds, hn::Set(d, 3.0F))), hn::Set(d, 4.5F));
        const V bend = hn::Mul(hn::Sub(hn::Sub(y1, y0), thirds), hn::Set(d, -4.5F));
        const V c2 = hn::Sub(bend, c3);
        return {y0, hn::Sub(hn::Sub(ends, c2), c3), c2, c3};
    }
    /// By what it is and its slopes at 0 and at 1 (Hermite).
    HWY_INLINE static Cubic between(V first, V last, V firstSlope, V lastSlope) {
        const V change = hn::Sub(last, first), slopes = hn::Add(firstSlope, lastSlope);
        const V c3 = hn::MulAdd(change, hn::Set(Floats(), -2.0F), slopes);
        return {first, firstSlope, hn::Sub(hn::Sub(change, firstSlope), c3), c3};
    }
    HWY_INLINE V at(V s) const { return hn::MulAdd(hn::MulAdd(hn::MulAdd(c3, s, c2), s, c1), s, c0); }
};

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
