// SPDX-License-Identifier: GPL-3.0-or-later
//
// The light that a packet gathers, a vector at a time. Compiled once for each target (Highway's
// foreach_target), hence without #pragma once.
#if defined(MOTE_LIGHT_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_LIGHT_INL_H
#undef MOTE_LIGHT_INL_H
#else
#define MOTE_LIGHT_INL_H
#endif

#include "server/render/cpu/volume_sample-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// exp(-x), x >= 0, to about 1e-7; 1 for 0.
HWY_INLINE V expMinus(V x) {
    const Floats d;
    const Ints ints;
    // Below 2^-126 there are no normal numbers; nothing is seen through that anyway.
    const V powers = hn::Max(hn::Mul(x, hn::Set(d, -1.44269504F)), hn::Set(d, -126.0F));
    const IntV whole = hn::NearestInt(powers);
    const V rest = hn::Sub(powers, hn::ConvertTo(d, whole));
    // 2^rest by its Taylor series: the next term is 1.6e-7 at 1/2 and less on average.
    V sum = hn::Set(d, 1.5403530e-4F);
    for (const float term : {1.3333558e-3F, 9.6181291e-3F, 5.5504109e-2F, 2.4022651e-1F, 6.9314718e-1F, 1.0F})
        sum = hn::MulAdd(sum, rest, hn::Set(d, term));
    return hn::BitCast(d, hn::Add(hn::BitCast(ints, sum), hn::ShiftLeft<23>(whole)));
}

/// Optical depth, and colour times optical depth.
struct Matter {
    V tau, red, green, blue;

    HWY_INLINE Matter() {
        const Floats d;
        tau = red = green = blue = hn::Zero(d);
    }
    HWY_INLINE void add(V depth, V r, V g, V b) {
        tau = hn::Add(tau, depth);
        red = hn::MulAdd(depth, r, red);
        green = hn::MulAdd(depth, g, green);
        blue = hn::MulAdd(depth, b, blue);
    }
    HWY_INLINE void add(V depth, const RootColor& root) {
        const V scaled = hn::Mul(depth, hn::Set(Floats(), RootColor::scale));
        tau = hn::Add(tau, depth);
        red = hn::MulAdd(scaled, hn::Mul(root.red, root.red), red);
        green = hn::MulAdd(scaled, hn::Mul(root.green, root.green), green);
        blue = hn::MulAdd(scaled, hn::Mul(root.blue, root.blue), blue);
    }
};

/// Light gathered so far and what is left of light from behind.
struct Light {
    V red, green, blue, left;

    HWY_INLINE Light() {
        const Floats d;
        red = green = blue = hn::Zero(d);
        left = hn::Set(d, 1.0F);
    }
    /// A stretch of one colour.
    HWY_INLINE void gather(V tau, V r, V g, V b) {
        const V passed = hn::Mul(left, expMinus(tau));
        const V share = hn::Sub(left, passed);
        red = hn::MulAdd(share, r, red);
        green = hn::MulAdd(share, g, green);
        blue = hn::MulAdd(share, b, blue);
        left = passed;
    }
    HWY_INLINE void gather(V tau, const RootColor& root) {
        const V passed = hn::Mul(left, expMinus(tau));
        const V share = hn::Mul(hn::Sub(left, passed), hn::Set(Floats(), RootColor::scale));
        red = hn::MulAdd(share, hn::Mul(root.red, root.red), red);
        green = hn::MulAdd(share, hn::Mul(root.green, root.green), green);
        blue = hn::MulAdd(share, hn::Mul(root.blue, root.blue), blue);
        left = passed;
    }
    /// Matter that is evenly mixed.
    HWY_INLINE void gather(const Matter& matter) {
        const Floats d;
        const V one = hn::Div(hn::Set(d, 1.0F), hn::Max(matter.tau, hn::Set(d, 1e-30F)));
        gather(matter.tau, hn::Mul(matter.red, one), hn::Mul(matter.green, one), hn::Mul(matter.blue, one));
    }
    HWY_INLINE bool gone() const {
        const Floats d;
        return hn::AllTrue(d, hn::Lt(left, hn::Set(d, 5e-5F)));  // shown in no picture of 8 bits
    }
};

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
