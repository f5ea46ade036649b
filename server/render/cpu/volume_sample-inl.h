// SPDX-License-Identifier: GPL-3.0-or-later
//
// Samples of a volume along the rays of a packet, a vector at a time. Compiled once for each target
// (Highway's foreach_target), hence without #pragma once.
#if defined(MOTE_VOLUME_SAMPLE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_VOLUME_SAMPLE_INL_H
#undef MOTE_VOLUME_SAMPLE_INL_H
#else
#define MOTE_VOLUME_SAMPLE_INL_H
#endif

#include <hwy/highway.h>

#include "server/render/cpu/composite_frame.h"
#include "server/render/cpu/packet_rays.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, Tile::packetPixels>;
using Ints = hn::RebindToSigned<Floats>;
using Words = hn::RebindToUnsigned<Floats>;
using V = hn::Vec<Floats>;
using IntV = hn::Vec<Ints>;
using WordV = hn::Vec<Words>;

/// What is read of one layer's volume.
struct VolumeSource {
    const std::uint8_t* words;
    float sheetRows;
    std::int32_t rowBytes;
    std::size_t sheetBytes;
    const VolumeTable::Integral* integrals;
    const std::uint32_t* colors;

    explicit VolumeSource(const VisibleVolume& visible)
        : words(reinterpret_cast<const std::uint8_t*>(visible.volume->words())),
          sheetRows(static_cast<float>(visible.volume->sheetRows())),
          rowBytes(static_cast<std::int32_t>(4 * visible.volume->rowWords())),
          sheetBytes(std::size_t{4} * visible.volume->rowWords() * visible.volume->sheetRows()),
          integrals(visible.table->integrals()),
          colors(visible.table->colors()) {}
};

/// Rays in registers, see PacketRays.
struct RayLanes {
    V entryX, entryY, entryZ, travelX, travelY, travelZ, enter, rate;

    HWY_INLINE RayLanes(const PacketRays& rays, std::size_t lane) {
        const Floats d;
        const auto load = [&](const Lanes& lanes) HWY_ATTR { return hn::LoadU(d, lanes.data() + lane); };
        entryX = load(rays.entry[0]), entryY = load(rays.entry[1]), entryZ = load(rays.entry[2]);
        travelX = load(rays.travel[0]), travelY = load(rays.travel[1]), travelZ = load(rays.travel[2]);
        enter = load(rays.enter), rate = load(rays.rate);
    }
    /// How far through the box the rays are in a slab.
    HWY_INLINE V way(V slab) const {
        const Floats d;
        return hn::Min(hn::Max(hn::Mul(hn::Sub(slab, enter), rate), hn::Zero(d)), hn::Set(d, 1.0F));
    }
};

/// Pairs of words, one from each of two vectors of 64-bit reads: the low and the high halves apart.
struct WordPairs {
    WordV low, high;
};

#if HWY_TARGET == HWY_SCALAR  // one lane: there are no halves and no pairs

/// Reads 8 bytes a lane at byte offsets.
HWY_INLINE WordPairs gatherPairs(const void* base, IntV offset) {
    const Words words;
    std::uint32_t pair[2];
    hwy::CopyBytes<sizeof(pair)>(static_cast<const std::uint8_t*>(base) + hn::GetLane(offset), pair);
    return {hn::Set(words, pair[0]), hn::Set(words, pair[1])};
}

/// Of two 15-bit cells in each word the mean, weighted by 15-bit weights; times PackedVolume::full.
HWY_INLINE V meanOfPair(WordV cells, WordV weights) {
    const std::uint32_t c = hn::GetLane(cells), w = hn::GetLane(weights);
    return hn::Set(Floats(), static_cast<float>((c & 0xffffU) * (w & 0xffffU) + (c >> 16) * (w >> 16)));
}

#else

/// Reads 8 bytes a lane at byte offsets.
HWY_INLINE WordPairs gatherPairs(const void* base, IntV offset) {
    const Words words;
    const hn::Repartition<std::uint64_t, Floats> reads;
    const hn::RebindToSigned<decltype(reads)> offsets;
    const auto first = hn::PromoteTo(offsets, hn::LowerHalf(offset));
    const auto second = hn::PromoteTo(offsets, hn::UpperHalf(hn::Half<Ints>(), offset));
    const auto* const bytes = static_cast<const std::uint64_t*>(base);
    const auto lower = hn::BitCast(words, hn::GatherOffset(reads, bytes, first));
    const auto upper = hn::BitCast(words, hn::GatherOffset(reads, bytes, second));
    return {hn::ConcatEven(words, upper, lower), hn::ConcatOdd(words, upper, lower)};
}

/// Of two 15-bit cells in each word the mean, weighted by 15-bit weights; times PackedVolume::full.
HWY_INLINE V meanOfPair(WordV cells, WordV weights) {
    const Ints ints;
    const hn::Repartition<std::int16_t, Floats> shorts;
    auto odd = hn::Zero(ints);
    const auto sum = hn::ReorderWidenMulAccumulate(ints, hn::BitCast(shorts, cells),
                                                   hn::BitCast(shorts, weights), hn::Zero(ints), odd);
    return hn::ConvertTo(Floats(), hn::RearrangeToOddPlusEven(sum, odd));
}

#endif

/// t along the rays, in cells of the VolumeTable.
HWY_INLINE V densityAt(const VolumeSource& source, const RayLanes& rays, V way) {
    const Floats d;
    const Ints ints;
    const Words words;
    const V x = hn::MulAdd(way, rays.travelX, rays.entryX);
    const V y = hn::MulAdd(way, rays.travelY, rays.entryY);
    const V z = hn::MulAdd(way, rays.travelZ, rays.entryZ);
    const IntV cellX = hn::ConvertTo(ints, x);
    const V floorX = hn::ConvertTo(d, cellX);
    const V floorY = hn::ConvertTo(d, hn::ConvertTo(ints, y));
    const V floorZ = hn::ConvertTo(d, hn::ConvertTo(ints, z));
    const IntV row = hn::ConvertTo(ints, hn::MulAdd(floorZ, hn::Set(d, source.sheetRows), floorY));
    const IntV offset = hn::Add(hn::Mul(row, hn::Set(ints, source.rowBytes)), hn::ShiftLeft<2>(cellX));
    const V full = hn::Set(d, static_cast<float>(PackedVolume::full));
    const WordV far = hn::BitCast(words, hn::ConvertTo(ints, hn::Mul(hn::Sub(y, floorY), full)));
    const WordV weights =
        hn::Add(hn::Sub(hn::ShiftLeft<16>(far), far), hn::Set(words, std::uint32_t{PackedVolume::full}));
    const WordPairs front = gatherPairs(source.words, offset);
    const WordPairs back = gatherPairs(source.words + source.sheetBytes, offset);
    const V shareX = hn::Sub(x, floorX);
    const auto along = [&](const WordPairs& pairs) HWY_ATTR {
        const V low = meanOfPair(pairs.low, weights);
        return hn::MulAdd(shareX, hn::Sub(meanOfPair(pairs.high, weights), low), low);
    };
    const V low = along(front);
    const V whole = hn::MulAdd(hn::Sub(z, floorZ), hn::Sub(along(back), low), low);
    constexpr float scale =
        static_cast<float>(VolumeTable::cells) / (float{PackedVolume::full} * float{PackedVolume::full});
    return hn::Mul(whole, hn::Set(d, scale));
}

/// A place on the rays with what a stretch needs of it.
struct Sample {
    V way;
    V density;   ///< cells of the VolumeTable
    V integral;  ///< of extinction up to this density
    V slope;     ///< extinction there
};

HWY_INLINE Sample sampleAt(const VolumeSource& source, const RayLanes& rays, V slab) {
    const Floats d;
    const Ints ints;
    const V way = rays.way(slab);
    const V density = densityAt(source, rays, way);
    // The very last entry has no slope: rounding may lead there and no further.
    const IntV cell = hn::ConvertTo(ints, hn::Min(density, hn::Set(d, float{VolumeTable::cells})));
    const WordPairs entry = gatherPairs(source.integrals, hn::ShiftLeft<3>(cell));
    const V slope = hn::BitCast(d, entry.high);
    const V integral = hn::MulAdd(slope, hn::Sub(density, hn::ConvertTo(d, cell)), hn::BitCast(d, entry.low));
    return {way, density, integral, slope};
}

/// 1 / x to about 1e-7 where x is a normal number.
HWY_INLINE V reciprocal(V x) {
    const Floats d;
    V result = hn::ApproximateReciprocal(x);
    for (int step = 0; step < 2; ++step) result = hn::Mul(result, hn::NegMulAdd(x, result, hn::Set(d, 2.0F)));
    return result;
}

/// Mean extinction over a stretch in which the density goes evenly from one sample to the next.
HWY_INLINE V meanExtinction(const Sample& from, const Sample& to) {
    const Floats d;
    const V change = hn::Sub(to.density, from.density);
    const auto wide = hn::Gt(hn::Abs(change), hn::Set(d, 1.0F));
    const V safe = hn::IfThenElse(wide, change, hn::Set(d, 1.0F));
    const V overall = hn::Mul(hn::Sub(to.integral, from.integral), reciprocal(safe));
    const V level = hn::Mul(hn::Add(from.slope, to.slope), hn::Set(d, 0.5F));
    return hn::IfThenElse(wide, overall, level);
}

/// The square roots of linear red, green and blue, times 1023.
struct RootColor {
    static constexpr float scale = 1.0F / (1023.0F * 1023.0F);  // to take the squares to 1
    V red, green, blue;
};

/// Of a stretch: where its extinction has its centre, as if it changed evenly.
HWY_INLINE RootColor colorBetween(const VolumeSource& source, const Sample& from, const Sample& to) {
    const Floats d;
    const Ints ints;
    const Words words;
    const V sum = hn::Add(from.slope, to.slope);
    const V share = hn::Mul(hn::MulAdd(to.slope, hn::Set(d, 2.0F), from.slope),
                            reciprocal(hn::Max(hn::Mul(sum, hn::Set(d, 3.0F)), hn::Set(d, 1e-20F))));
    const V place = hn::MulAdd(hn::IfThenElse(hn::Gt(sum, hn::Zero(d)), share, hn::Set(d, 0.5F)),
                               hn::Sub(to.density, from.density), hn::Add(from.density, hn::Set(d, 0.5F)));
    const IntV index = hn::ConvertTo(ints, hn::Min(place, hn::Set(d, float{VolumeTable::cells})));
    const WordV packed = hn::BitCast(
        words, hn::GatherIndex(ints, reinterpret_cast<const std::int32_t*>(source.colors), index));
    const WordV mask = hn::Set(words, 1023U);
    const auto root = [&](WordV word) HWY_ATTR { return hn::ConvertTo(d, hn::BitCast(ints, word)); };
    return {root(hn::And(packed, mask)), root(hn::And(hn::ShiftRight<10>(packed), mask)),
            root(hn::ShiftRight<20>(packed))};
}

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
