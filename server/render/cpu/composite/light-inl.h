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

#include "server/render/cpu/composite/density_sample-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// exp(-x), x >= 0, to about 1e-7; 1 for 0.
HWY_INLINE V expMinus(V x) {
    const Floats d;
    const Ints ints;
    // Below 2^-126 there are no normal numbers; nothing is seen through that anyway.
    const V powers = hn::Max(hn::Mul(x, hn::Set(d, -1.44269504F)), hn::Set(d, -126.0F));
    // To the nearest integer: 1.5 * 2^23 leaves no bits for a fraction, of either sign.
    const V shifted = hn::Add(powers, hn::Set(d, 12582912.0F));
    const V rest = hn::Sub(powers, hn::Sub(shifted, hn::Set(d, 12582912.0F)));
    // 2^rest by its Taylor series: the next term is 1.6e-7 at 1/2 and less on average.
    V sum = hn::MulAdd(hn::Set(d, 1.5403530e-4F), rest, hn::Set(d, 1.3333558e-3F));
    sum = hn::MulAdd(sum, rest, hn::Set(d, 9.6181291e-3F));
    sum = hn::MulAdd(sum, rest, hn::Set(d, 5.5504109e-2F));
    sum = hn::MulAdd(sum, rest, hn::Set(d, 2.4022651e-1F));
    sum = hn::MulAdd(sum, rest, hn::Set(d, 6.9314718e-1F));
    sum = hn::MulAdd(sum, rest, hn::Set(d, 1.0F));
    // The integer, in the low bits, becomes the exponent.
    const IntV exponent = hn::ShiftLeft<23>(hn::BitCast(ints, shifted));
    return hn::BitCast(d, hn::Add(hn::BitCast(ints, sum), exponent));
}

/// -log(x), x from 1e-30 to 1, to about 1e-6.
HWY_INLINE V minusLog(V x) {
    const Floats d;
    const Ints ints;
    // x = 2^whole * rest, rest from sqrt(1/2) to sqrt(2).
    const IntV bits = hn::Sub(hn::BitCast(ints, x), hn::Set(ints, 0x3f3504f3));
    const IntV whole = hn::ShiftRight<23>(bits);
    const V rest = hn::BitCast(d, hn::Sub(hn::BitCast(ints, x), hn::ShiftLeft<23>(whole)));
    const V one = hn::Set(d, 1.0F);
    const V u = hn::Div(hn::Sub(rest, one), hn::Add(rest, one)), square = hn::Mul(u, u);
    V series = hn::MulAdd(square, hn::Set(d, 2.0F / 7.0F), hn::Set(d, 2.0F / 5.0F));
    series = hn::MulAdd(square, series, hn::Set(d, 2.0F / 3.0F));
    series = hn::Mul(u, hn::MulAdd(square, series, hn::Set(d, 2.0F)));
    return hn::Sub(hn::Mul(hn::ConvertTo(d, whole), hn::Set(d, -0.693147181F)), series);
}

/// Where the light of a segment of this optical depth, evenly filled, comes from on average: 1/2 where it is
/// thin, less where its front hides its back. 1/x - 1/(exp(x) - 1), to within 0.025.
HWY_INLINE V centreOfLight(V depth) {
    const Floats d;
    const V above = hn::Add(depth, hn::Set(d, 12.0F));
    const V below = hn::MulAdd(hn::Add(depth, hn::Set(d, 6.0F)), depth, hn::Set(d, 24.0F));
    return hn::Div(above, below);
}

/// The mean colour between two samples, weighted by extinction.
struct Blend {
    V share;  ///< of the second

    /// Where extinction changes evenly its centre lies at 1/2 + (second - first) / (12 mean); with the true
    /// mean this is also right where it begins or ends on the way.
    HWY_INLINE Blend(const Sample& from, const Sample& to, V mean) {
        const Floats d;
        const V change = hn::Mul(hn::Sub(to.slope, from.slope), hn::Set(d, 1.0F / 12.0F));
        const V centre = hn::MulAdd(change, reciprocal(hn::Max(mean, hn::Set(d, 1e-12F))), hn::Set(d, 0.5F));
        share = hn::Min(hn::Max(centre, hn::Zero(d)), hn::Set(d, 1.0F));
    }
    /// Weighted also by what is seen of it from the front; `depth`: optical, of the whole.
    HWY_INLINE Blend(const Sample& from, const Sample& to, V mean, V depth) : Blend(from, to, mean) {
        const Floats d;
        const V seen = hn::Add(hn::Sub(share, hn::Set(d, 0.5F)), centreOfLight(depth));
        share = hn::Min(hn::Max(seen, hn::Zero(d)), hn::Set(d, 1.0F));
    }
    HWY_INLINE V operator()(V one, V other) const { return hn::MulAdd(share, hn::Sub(other, one), one); }
};

/// What is in one segment: optical depth, and colour times optical depth, which may change evenly from its
/// front to its back: by so much, around so much in its middle.
struct Matter {
    V tau, red, green, blue;
    V redChange, greenChange, blueChange;

    HWY_INLINE Matter() {
        const Floats d;
        tau = red = green = blue = redChange = greenChange = blueChange = hn::Zero(d);
    }
    HWY_INLINE void add(V depth, V r, V g, V b) {
        tau = hn::Add(tau, depth);
        red = hn::MulAdd(depth, r, red);
        green = hn::MulAdd(depth, g, green);
        blue = hn::MulAdd(depth, b, blue);
    }
    /// Matter between two samples: its colour is exact where extinction and colour change evenly.
    HWY_INLINE void add(V depth, const Sample& from, const Sample& to, V mean) {
        const Blend blend(from, to, mean);
        const V scaled = hn::Mul(depth, hn::Set(Floats(), colorScale));
        tau = hn::Add(tau, depth);
        red = hn::MulAdd(scaled, blend(from.red, to.red), red);
        green = hn::MulAdd(scaled, blend(from.green, to.green), green);
        blue = hn::MulAdd(scaled, blend(from.blue, to.blue), blue);
        redChange = hn::MulAdd(scaled, hn::Sub(to.red, from.red), redChange);
        greenChange = hn::MulAdd(scaled, hn::Sub(to.green, from.green), greenChange);
        blueChange = hn::MulAdd(scaled, hn::Sub(to.blue, from.blue), blueChange);
    }
};

/// Light gathered so far and what is left of light from behind.
struct Light {
    /// What is left where no picture of 8 bits shows more: of any ray, and of one that is bright as a share
    /// of its darkest component. What comes to 1 changes by .45 of a step then, what is darker by less, as
    /// the slope of sRGB is about .44 c^-.58.
    static constexpr float least = 5e-5F, leastOfDarkest = 4e-3F;

    V red, green, blue, left;

    HWY_INLINE Light() {
        const Floats d;
        red = green = blue = hn::Zero(d);
        left = hn::Set(d, 1.0F);
    }
    /// A segment of one colour.
    HWY_INLINE void gather(V tau, V r, V g, V b) {
        const V passed = hn::Mul(left, expMinus(tau));
        const V share = hn::Sub(left, passed);
        red = hn::MulAdd(share, r, red);
        green = hn::MulAdd(share, g, green);
        blue = hn::MulAdd(share, b, blue);
        left = passed;
    }
    /// A segment between two samples.
    HWY_INLINE void gather(V depth, const Sample& from, const Sample& to, V mean) {
        const Blend blend(from, to, mean, depth);
        const V passed = hn::Mul(left, expMinus(depth));
        const V share = hn::Mul(hn::Sub(left, passed), hn::Set(Floats(), colorScale));
        red = hn::MulAdd(share, blend(from.red, to.red), red);
        green = hn::MulAdd(share, blend(from.green, to.green), green);
        blue = hn::MulAdd(share, blend(from.blue, to.blue), blue);
        left = passed;
    }
    /// Matter that is evenly mixed.
    HWY_INLINE void gather(const Matter& matter) {
        const Floats d;
        const V one = hn::Div(hn::Set(d, 1.0F), hn::Max(matter.tau, hn::Set(d, 1e-30F)));
        const V place = hn::Sub(centreOfLight(matter.tau), hn::Set(d, 0.5F));
        const auto seen = [&](V middle, V change) HWY_ATTR {
            return hn::Max(hn::Mul(hn::MulAdd(place, change, middle), one), hn::Zero(d));
        };
        gather(matter.tau, seen(matter.red, matter.redChange), seen(matter.green, matter.greenChange),
               seen(matter.blue, matter.blueChange));
    }
    /// The rays by which something is still seen.
    HWY_INLINE hn::Mask<Floats> seen() const { return hn::Gt(left, hn::Zero(Floats())); }
    /// Lets rays end of which so little is left, each by itself; whether all have.
    HWY_INLINE bool gone() {
        const Floats d;
        const V darkest = hn::Min(hn::Min(red, green), blue);
        return gone(hn::Max(hn::Mul(darkest, hn::Set(d, leastOfDarkest)), hn::Set(d, least)));
    }
    /// The same where more may be left, of each ray, and nothing more be seen.
    HWY_INLINE bool gone(V mostLeft) { return gone(mostLeft, hn::Gt(left, hn::Zero(Floats()))); }
    /// The same of some rays.
    HWY_INLINE bool gone(V mostLeft, hn::Mask<Floats> which) {
        const Floats d;
        left = hn::IfThenZeroElse(hn::And(which, hn::Lt(left, mostLeft)), left);
        return hn::AllTrue(d, hn::Le(left, hn::Zero(d)));
    }
};

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
