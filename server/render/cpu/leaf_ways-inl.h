// SPDX-License-Identifier: GPL-3.0-or-later
//
// How the points of leaves fall into pixels: by how many pixels their leaf meets, a block of leaves at a
// time. For the files that are compiled for each instruction set.
#if defined(MOTE_LEAF_WAYS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_LEAF_WAYS_INL_H
#undef MOTE_LEAF_WAYS_INL_H
#else
#define MOTE_LEAF_WAYS_INL_H
#endif

#include <hwy/highway.h>

#include <array>
#include <cstdint>

#include "server/render/cpu/point_places-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace {

/// How a leaf is counted.
enum Way : std::int32_t { notAtAll, inOnePixel, inFourPixels, inside, atBorder };

/// How each leaf of a block is counted, and the first pixel that it meets, row by row in the picture.
struct LeafWays {
    HWY_ALIGN std::array<std::int32_t, LeafPlaces::block> way, first;

    HWY_INLINE void choose(const PointMap& map, const LeafPlaces& places, std::size_t size) {
        for (std::size_t i = 0; i < size; i += hn::Lanes(floats)) chooseVector(map, places, i);
    }

  private:
    struct Span {
        Float first;  ///< pixel
        Mask outside, one, whole, wholeTwo;
    };

    HWY_INLINE static Span spanOf(const LeafPlaces::Numbers& from, const LeafPlaces::Numbers& to,
                                  std::size_t i, std::uint32_t pixels) {
        // Points are rounded, by no more than this: they are to stay in the picture.
        constexpr float margin = 1.0F / 64.0F;
        const Float least = hn::Load(floats, from.data() + i), most = hn::Load(floats, to.data() + i);
        const Float zero = hn::Zero(floats), end = hn::Set(floats, static_cast<float>(pixels));
        const Float first = hn::Floor(least), edge = hn::Set(floats, margin);
        return {first, hn::Or(hn::Lt(most, zero), hn::Gt(least, end)), hn::Eq(first, hn::Floor(most)),
                hn::And(hn::Ge(least, edge), hn::Le(most, hn::Sub(end, edge))),
                hn::And(hn::Ge(first, zero), hn::Le(hn::Add(first, hn::Set(floats, 2.0F)), end))};
    }

    HWY_INLINE void chooseVector(const PointMap& map, const LeafPlaces& places, std::size_t i) {
        const Span columns = spanOf(places.left, places.right, i, map.width);
        const Span rows = spanOf(places.top, places.bottom, i, map.height);
        const Mask two = hn::Gt(hn::Load(floats, places.column.data() + i), columns.first);
        const auto either = [](Mask mask, Way chosen, Int otherwise) {
            return hn::IfThenElse(hn::RebindMask(ints, mask), hn::Set(ints, chosen), otherwise);
        };
        const Mask wholeTwo = hn::And(columns.wholeTwo, rows.wholeTwo);
        Int ways = either(hn::And(columns.whole, rows.whole), inside, hn::Set(ints, atBorder));
        ways = either(hn::And(two, wholeTwo), inFourPixels, ways);
        ways = either(hn::And(wholeTwo, hn::And(columns.one, rows.one)), inOnePixel, ways);
        ways = either(hn::Or(columns.outside, rows.outside), notAtAll, ways);
        hn::Store(ways, ints, way.data() + i);
        const Int row = hn::ConvertTo(ints, rows.first), column = hn::ConvertTo(ints, columns.first);
        const Int pixel = hn::Add(hn::Mul(row, hn::Set(ints, static_cast<std::int32_t>(map.width))), column);
        hn::Store(pixel, ints, first.data() + i);
    }
};

}  // namespace
}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
