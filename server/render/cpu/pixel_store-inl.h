// SPDX-License-Identifier: GPL-3.0-or-later
//
// From linear light to the bytes of a picture, a vector at a time. Compiled once for each target (Highway's
// foreach_target), hence without #pragma once.
#if defined(MOTE_PIXEL_STORE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_PIXEL_STORE_INL_H
#undef MOTE_PIXEL_STORE_INL_H
#else
#define MOTE_PIXEL_STORE_INL_H
#endif

#include "server/render/cpu/light-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// The sRGB encoding of a linear component, 0 to 255, rounded to the nearest; at most 0.003 of a step off
/// before rounding.
HWY_INLINE WordV encoded(V linear) {
    const Floats d;
    const V x = hn::Min(hn::Max(linear, hn::Zero(d)), hn::Set(d, 1.0F));
    // IEC 61966-2-1 in the fourth root of x, in which the power 1/2.4 is nearly a polynomial: interpolated at
    // the Chebyshev nodes of its range.
    const V root = hn::Sqrt(hn::Sqrt(x));
    V curved = hn::MulAdd(hn::Set(d, -16.0035428F), root, hn::Set(d, 69.5518221F));
    curved = hn::MulAdd(curved, root, hn::Set(d, -142.176691F));
    curved = hn::MulAdd(curved, root, hn::Set(d, 317.274569F));
    curved = hn::MulAdd(curved, root, hn::Set(d, 42.0683701F));
    curved = hn::MulAdd(curved, root, hn::Set(d, -15.7155749F));
    const V straight = hn::Mul(x, hn::Set(d, 255.0F * 12.92F));
    const V value = hn::IfThenElse(hn::Le(x, hn::Set(d, 0.0031308F)), straight, curved);
    return hn::BitCast(Words(), hn::NearestInt(value));
}

/// A half float's bits, rounded to the nearest, ties to even; at most the greatest finite one. x >= 0.
HWY_INLINE WordV halfBits(V x) {
    const Floats d;
    const Words words;
    const V held = hn::Min(x, hn::Set(d, 65504.0F));
    // Below the least normal half, adding 1/2 leaves the bits where a half has them.
    const V shift = hn::Set(d, 0.5F);
    const WordV small = hn::Sub(hn::BitCast(words, hn::Add(held, shift)), hn::BitCast(words, shift));
    const WordV bits = hn::BitCast(words, held);
    const WordV odd = hn::And(hn::ShiftRight<13>(bits), hn::Set(words, 1U));
    // The exponents' biases are 127 and 15.
    const WordV rebased = hn::Sub(bits, hn::Set(words, 112U << 23));
    const WordV normal = hn::ShiftRight<13>(hn::Add(hn::Add(rebased, hn::Set(words, 0xfffU)), odd));
    const auto tiny = hn::RebindMask(words, hn::Lt(held, hn::Set(d, 0x1p-14F)));
    return hn::IfThenElse(tiny, small, normal);
}

/// Light with what comes through of the background, as words of a picture's pixels: one or two a pixel. A
/// pixel that nothing was in front of has the very bytes of `blank`.
HWY_INLINE void storePixels(const CompositeFrame& frame, const Light& light, std::uint32_t* pixels) {
    const Floats d;
    const Words words;
    const V red = hn::MulAdd(light.left, hn::Set(d, frame.background.x), light.red);
    const V green = hn::MulAdd(light.left, hn::Set(d, frame.background.y), light.green);
    const V blue = hn::MulAdd(light.left, hn::Set(d, frame.background.z), light.blue);
    const auto blank = hn::RebindMask(words, hn::Eq(light.left, hn::Set(d, 1.0F)));
    std::uint32_t blankWords[2];
    hwy::CopyBytes<sizeof(blankWords)>(frame.blank.data(), blankWords);
    const WordV first = hn::Set(words, blankWords[0]);
    if (frame.format == PixelFormat::srgb8) {
        const WordV color = hn::Or(hn::Or(encoded(red), hn::ShiftLeft<8>(encoded(green))),
                                   hn::Or(hn::ShiftLeft<16>(encoded(blue)), hn::Set(words, 0xff000000U)));
        hn::StoreU(hn::IfThenElse(blank, first, color), words, pixels);
        return;
    }
    constexpr std::uint32_t opaque = 0x3c00U << 16;  // 1.0
    const WordV low = hn::Or(halfBits(red), hn::ShiftLeft<16>(halfBits(green)));
    const WordV high = hn::Or(halfBits(blue), hn::Set(words, opaque));
    hn::StoreInterleaved2(hn::IfThenElse(blank, first, low),
                          hn::IfThenElse(blank, hn::Set(words, blankWords[1]), high), words, pixels);
}

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
