// SPDX-License-Identifier: GPL-3.0-or-later
//
// Samples of a volume along the rays of a packet, a vector at a time. Compiled once for each target
// (Highway's foreach_target), hence without #pragma once.
#if defined(MOTE_DENSITY_SAMPLE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_DENSITY_SAMPLE_INL_H
#undef MOTE_DENSITY_SAMPLE_INL_H
#else
#define MOTE_DENSITY_SAMPLE_INL_H
#endif

#include <hwy/highway.h>

#include <array>

#include "server/render/cpu/composite_frame.h"
#include "server/render/cpu/packet.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, Tile::packetPixels>;
using Ints = hn::RebindToSigned<Floats>;
using Words = hn::RebindToUnsigned<Floats>;
using V = hn::Vec<Floats>;
using IntV = hn::Vec<Ints>;
using WordV = hn::Vec<Words>;

/// The whole part of a number from 1/4 to 2^22, as a number and in the low bits of a word; a whole number may
/// become the one below and 1. Cheaper than conversions, which must think of numbers beyond an integer's.
struct Whole {
    static constexpr std::uint32_t bias = 0x4b000000U;  ///< the word's other bits: those of 2^23
    V value;
    WordV word;

    HWY_INLINE explicit Whole(V x) {
        const Floats d;
        const V shifted = hn::Add(x, hn::Set(d, 8388607.5F));
        value = hn::Sub(shifted, hn::Set(d, 8388608.0F));
        word = hn::BitCast(Words(), shifted);
    }
    HWY_INLINE IntV number() const { return hn::BitCast(Ints(), hn::Sub(word, hn::Set(Words(), bias))); }
};

/// The nearest integer to a number from 0 to 2^22 in the low bits of a word, the others being Whole::bias.
HWY_INLINE WordV nearestWord(V x) {
    return hn::BitCast(Words(), hn::Add(x, hn::Set(Floats(), 8388608.0F)));
}

/// A weight of 1, of those of two neighbours that lie in one word. A power of two: where all cells are alike
/// their mean is exact, and on the same side of a step of a curve by all kinds of vectors.
constexpr std::uint32_t fullWeight = 16384;

/// The weights of two neighbours, by the share of the way to the second; that one's is in the high half.
HWY_INLINE WordV weightsOf(V share) {
    const WordV far = nearestWord(hn::Mul(share, hn::Set(Floats(), static_cast<float>(fullWeight))));
    return hn::Or(hn::ShiftLeft<16>(far), hn::Sub(hn::Set(Words(), Whole::bias + fullWeight), far));
}

/// What is read of a field of densities.
struct DensitySource {
    const std::uint8_t* words;
    float sheetRows;
    std::uint32_t rowBytes;
    std::size_t sheetBytes;
    const TransferTable::Entry* entries;

    explicit DensitySource(const VisibleField& visible)
        : words(reinterpret_cast<const std::uint8_t*>(visible.volume->words())),
          sheetRows(static_cast<float>(visible.volume->sheetRows())),
          rowBytes(4 * visible.volume->rowWords()),
          sheetBytes(std::size_t{4} * visible.volume->rowWords() * visible.volume->sheetRows()),
          entries(visible.seen.table->entries()) {}
};

/// Rays in registers, see PacketRays.
struct RayLanes {
    V entryX, entryY, entryZ, travelX, travelY, travelZ;
    V enter, rate, start;  ///< start: -enter * rate

    HWY_INLINE RayLanes(const PacketRays& rays, std::size_t lane) {
        const Floats d;
        const auto load = [&](const Lanes& lanes) HWY_ATTR { return hn::LoadU(d, lanes.data() + lane); };
        entryX = load(rays.entry[0]), entryY = load(rays.entry[1]), entryZ = load(rays.entry[2]);
        travelX = load(rays.travel[0]), travelY = load(rays.travel[1]), travelZ = load(rays.travel[2]);
        enter = load(rays.enter), rate = load(rays.rate), start = load(rays.start);
    }
    /// How far through the box the rays are in a slab.
    HWY_INLINE V way(V slab) const {
        const Floats d;
        return hn::Min(hn::Max(hn::MulAdd(slab, rate, start), hn::Zero(d)), hn::Set(d, 1.0F));
    }
};

/// Pairs of words that were read as 8 bytes each, the low and the high ones apart.
struct WordPairs {
    WordV low, high;
};

/// Entries of a TransferTable.
struct Entries {
    V value, start, bend;
    WordV color;
};

#if HWY_TARGET == HWY_SCALAR  // one lane: there are no halves and no pairs

using LaneNumbers = IntV;

/// 8 bytes a lane, as they were read.
using Reads = WordPairs;

/// Reads at byte offsets.
HWY_INLINE Reads gather(const void* base, IntV offset) {
    const Words words;
    std::uint32_t pair[2];
    hwy::CopyBytes<sizeof(pair)>(static_cast<const std::uint8_t*>(base) + hn::GetLane(offset), pair);
    return {hn::Set(words, pair[0]), hn::Set(words, pair[1])};
}
HWY_INLINE WordPairs pairsOf(const Reads& reads) {
    return reads;
}
HWY_INLINE Entries readEntries(const TransferTable::Entry* entries, IntV cell) {
    const auto& entry = entries[hn::GetLane(cell)];
    const auto set = [](float x) { return hn::Set(Floats(), x); };
    return {set(entry.value), set(entry.start), set(entry.bend), hn::Set(Words(), entry.color)};
}

/// The mean of the two 15-bit cells in each word, by weights that add up to one; times fullWeight.
HWY_INLINE V meanOfPair(WordV cells, WordV weights) {
    const std::uint32_t c = hn::GetLane(cells), w = hn::GetLane(weights);
    return hn::Set(Floats(), static_cast<float>((c & 0xffffU) * (w & 0xffffU) + (c >> 16) * (w >> 16)));
}

#else

/// Numbers of lanes, for addresses; without a sign, which would have to be extended.
struct LaneNumbers {
    alignas(64) std::array<std::uint32_t, hn::MaxLanes(Words())> values;

    HWY_INLINE explicit LaneNumbers(IntV numbers) {
        hn::Store(hn::BitCast(Words(), numbers), Words(), values.data());
    }
};

/// 8 bytes a lane, as they were read: of each four lanes the words of the first two, interleaved, and those
/// of the other two.
struct Reads {
    WordV first, second;
};

/// Reads as many bytes as a lane of D has from each of some addresses.
template <class D>
HWY_INLINE hn::Vec<D> loadEach(D d, const std::uint8_t* base, const std::uint32_t* offset) {
    if constexpr (hn::MaxLanes(D()) > 1) {
        const hn::Half<D> half;
        return hn::Combine(d, loadEach(half, base, offset + hn::MaxLanes(half)),
                           loadEach(half, base, offset));
    } else {
        return hn::LoadU(d, reinterpret_cast<const hn::TFromD<D>*>(base + *offset));
    }
}

/// 8 bytes from the first two of each four addresses, as Reads has them.
template <class D>
HWY_INLINE hn::Vec<D> loadPairs(D d, const std::uint8_t* base, const std::uint32_t* offset) {
    const hn::Half<D> half;
    if constexpr (hn::MaxLanes(D()) > 4) {
        return hn::Combine(d, loadPairs(half, base, offset + hn::MaxLanes(half)),
                           loadPairs(half, base, offset));
    } else {
        const auto load = [&](std::uint32_t at) HWY_ATTR {
            return hn::ZeroExtendVector(d,
                                        hn::LoadU(half, reinterpret_cast<const std::uint32_t*>(base + at)));
        };
        return hn::InterleaveLower(d, load(offset[0]), load(offset[1]));
    }
}

/// Reads at byte offsets. Plain loads: the processor's own gathers take as long or longer on all but a few.
HWY_INLINE Reads gather(const void* base, const LaneNumbers& offsets) {
    const auto* const bytes = static_cast<const std::uint8_t*>(base);
    return {loadPairs(Words(), bytes, offsets.values.data()),
            loadPairs(Words(), bytes, offsets.values.data() + 2)};
}
HWY_INLINE WordPairs pairsOf(const Reads& reads) {
    const Words words;
    const hn::Repartition<std::uint64_t, Floats> pairs;
    const auto first = hn::BitCast(pairs, reads.first), second = hn::BitCast(pairs, reads.second);
    return {hn::BitCast(words, hn::InterleaveLower(pairs, first, second)),
            hn::BitCast(words, hn::InterleaveUpper(pairs, first, second))};
}

/// 16 bytes of each fourth lane's entry, at byte offsets.
template <class D>
HWY_INLINE hn::Vec<D> loadBlocks(D d, const std::uint8_t* entries, const std::uint32_t* offset) {
    if constexpr (hn::MaxLanes(D()) > 4) {
        const hn::Half<D> half;
        return hn::Combine(d, loadBlocks(half, entries, offset + hn::MaxLanes(half)),
                           loadBlocks(half, entries, offset));
    } else {
        return hn::Load(d, reinterpret_cast<const std::uint32_t*>(entries + *offset));
    }
}
HWY_INLINE Entries readEntries(const TransferTable::Entry* entries, IntV cell) {
    const Words words;
    const Floats floats;
    const hn::Repartition<std::uint64_t, Floats> pairs;
    static_assert(sizeof(TransferTable::Entry) == 1 << 4);
    const LaneNumbers offsets(hn::ShiftLeft<4>(cell));
    const auto* const bytes = reinterpret_cast<const std::uint8_t*>(entries);
    const auto block = [&](std::size_t i)
                           HWY_ATTR { return loadBlocks(words, bytes, offsets.values.data() + i); };
    const auto first = block(0), second = block(1), third = block(2), fourth = block(3);
    const auto low = hn::BitCast(pairs, hn::InterleaveLower(words, first, second));
    const auto high = hn::BitCast(pairs, hn::InterleaveLower(words, third, fourth));
    const auto lowColor = hn::BitCast(pairs, hn::InterleaveUpper(words, first, second));
    const auto highColor = hn::BitCast(pairs, hn::InterleaveUpper(words, third, fourth));
    return {hn::BitCast(floats, hn::InterleaveLower(pairs, low, high)),
            hn::BitCast(floats, hn::InterleaveUpper(pairs, low, high)),
            hn::BitCast(floats, hn::InterleaveUpper(pairs, lowColor, highColor)),
            hn::BitCast(words, hn::InterleaveLower(pairs, lowColor, highColor))};
}

/// The mean of the two 15-bit cells in each word, by weights that add up to one; times fullWeight.
HWY_INLINE V meanOfPair(WordV cells, WordV weights) {
    const Ints ints;
    const hn::Repartition<std::int16_t, Floats> shorts;
    auto odd = hn::Zero(ints);
    const auto sum = hn::ReorderWidenMulAccumulate(ints, hn::BitCast(shorts, cells),
                                                   hn::BitCast(shorts, weights), hn::Zero(ints), odd);
    return hn::ConvertTo(Floats(), hn::RearrangeToOddPlusEven(sum, odd));
}

#endif

/// A sample is taken in three steps, so that a march can have each of them under way for another sample:
/// reads of memory take long, and the processor looks only so far ahead. First the 2 x 2 x 2 cells are read.
struct CellReads {
    Reads front, back;
};

HWY_INLINE CellReads readCells(const DensitySource& source, IntV offset) {
    const LaneNumbers offsets(offset);
    return {gather(source.words, offsets), gather(source.words + source.sheetBytes, offsets)};
}

/// Where the words of a cell are, from the whole parts of its place.
HWY_INLINE IntV cellOffset(const DensitySource& source, const Whole& x, const Whole& y, const Whole& z) {
    const Words words;
    const WordV row = nearestWord(hn::MulAdd(z.value, hn::Set(Floats(), source.sheetRows), y.value));
    const WordV biased = hn::Add(hn::Mul(row, hn::Set(words, source.rowBytes)), hn::ShiftLeft<2>(x.word));
    return hn::BitCast(Ints(), hn::Sub(biased, hn::Set(words, Whole::bias * (source.rowBytes + 4U))));
}

/// t in a cell, as the TransferTable counts it; shares of the way from its first corner to its last.
HWY_INLINE V densityIn(const WordPairs& front, const WordPairs& back, V shareX, V shareY, V shareZ) {
    const Floats d;
    const WordV weights = weightsOf(shareY);
    const auto along = [&](const WordPairs& pairs) HWY_ATTR {
        const V low = meanOfPair(pairs.low, weights);
        return hn::MulAdd(shareX, hn::Sub(meanOfPair(pairs.high, weights), low), low);
    };
    const V low = along(front);
    const V mean = hn::MulAdd(shareZ, hn::Sub(along(back), low), low);
    constexpr float scale =
        static_cast<float>(TransferTable::cells) / (float{PackedVolume::full} * float{fullWeight});
    return hn::MulAdd(mean, hn::Set(d, scale), hn::Set(d, 1.0F));
}

/// Then, from their density, the tables.
struct TableReads {
    V way, density, rest;
    Entries entry;
};

HWY_INLINE TableReads readTable(const DensitySource& source, V way, V density) {
    const Whole whole(density);
    return {way, density, hn::Sub(density, whole.value), readEntries(source.entries, whole.number())};
}

/// And then it is a place on the rays with what a segment needs of it.
struct Sample {
    V way;
    V density;           ///< t as the TransferTable counts it
    V integral;          ///< of extinction up to this density
    V slope;             ///< extinction there
    V red, green, blue;  ///< linear, times 1 / colorScale
};
constexpr float colorScale = 1.0F / (1023.0F * 1023.0F);

HWY_INLINE Sample sampleOf(const TableReads& table) {
    const Floats d;
    const Words words;
    const V half = hn::MulAdd(table.entry.bend, table.rest, table.entry.start);
    const V integral = hn::MulAdd(half, table.rest, table.entry.value);
    const V slope = hn::MulAdd(table.entry.bend, table.rest, half);
    const WordV color = table.entry.color;
    const auto component = [&](WordV word) HWY_ATTR {
        const V root = hn::ConvertTo(d, hn::BitCast(Ints(), word));
        return hn::Mul(root, root);
    };
    const WordV mask = hn::Set(words, 1023U);
    return {table.way,
            table.density,
            integral,
            slope,
            component(hn::And(color, mask)),
            component(hn::And(hn::ShiftRight<10>(color), mask)),
            component(hn::ShiftRight<20>(color))};
}

/// A place on the rays, in its cell.
struct Place {
    V way, shareX, shareY, shareZ;
    IntV offset;  ///< of the cell's words
};

HWY_INLINE Place placeAt(const DensitySource& source, const RayLanes& rays, V way) {
    const V x = hn::MulAdd(way, rays.travelX, rays.entryX);
    const V y = hn::MulAdd(way, rays.travelY, rays.entryY);
    const V z = hn::MulAdd(way, rays.travelZ, rays.entryZ);
    const Whole wholeX(x), wholeY(y), wholeZ(z);
    return {way, hn::Sub(x, wholeX.value), hn::Sub(y, wholeY.value), hn::Sub(z, wholeZ.value),
            cellOffset(source, wholeX, wholeY, wholeZ)};
}

/// Lets the cells around the first and the last ray's place be brought near. The others' are mostly the same:
/// rays side by side go through the same rows.
HWY_INLINE void prefetchCells(const DensitySource& source, const Place& place) {
    constexpr std::size_t last = hn::MaxLanes(Ints()) - 1;
    for (const std::int32_t offset : {hn::GetLane(place.offset), hn::ExtractLane(place.offset, last)}) {
        __builtin_prefetch(source.words + offset);
        __builtin_prefetch(source.words + source.sheetBytes + offset);
    }
}

HWY_INLINE V densityAt(const DensitySource& source, const Place& place) {
    const CellReads cells = readCells(source, place.offset);
    return densityIn(pairsOf(cells.front), pairsOf(cells.back), place.shareX, place.shareY, place.shareZ);
}

HWY_INLINE Sample sampleAt(const DensitySource& source, const RayLanes& rays, V way) {
    return sampleOf(readTable(source, way, densityAt(source, placeAt(source, rays, way))));
}

/// 1 / x, rounded to the nearest: a guess by the processor's own table would differ from maker to maker.
HWY_INLINE V reciprocal(V x) {
    return hn::Div(hn::Set(Floats(), 1.0F), x);
}

/// What lies between two samples, the density taken as linear.
struct Piece {
    V mean;   ///< extinction
    V depth;  ///< optical depth, over that of a way of length 1

    HWY_INLINE Piece(const Sample& from, const Sample& to) {
        const Floats d;
        const V change = hn::Sub(to.density, from.density);
        const auto wide = hn::Gt(hn::Abs(change), hn::Set(d, 1.0F));
        const V safe = hn::IfThenElse(wide, change, hn::Set(d, 1.0F));
        const V overall = hn::Mul(hn::Sub(to.integral, from.integral), reciprocal(safe));
        const V level = hn::Mul(hn::Add(from.slope, to.slope), hn::Set(d, 0.5F));
        mean = hn::Max(hn::IfThenElse(wide, overall, level), hn::Zero(d));
        depth = hn::Mul(mean, hn::Sub(to.way, from.way));
    }
};

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
