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

#include "server/render/cpu/composite/composite_frame.h"
#include "server/render/cpu/composite/packet.h"
#include "server/render/cpu/composite/truncated-inl.h"

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

/// What is read of a step's volume.
struct DensitySource {
    const std::uint8_t* words;
    float sheetRows;
    std::uint32_t rowBytes;
    std::size_t sheetBytes;
    const TransferTable::Entry* entries;
    float strength;              ///< times extinction
    float tableScale, tableLow;  ///< of a cell's t, to places in the table

    explicit DensitySource(const VisibleField& visible)
        : words(reinterpret_cast<const std::uint8_t*>(visible.volume->words())),
          sheetRows(static_cast<float>(visible.volume->sheetRows())),
          rowBytes(4 * visible.volume->rowWords()),
          sheetBytes(std::size_t{4} * visible.volume->rowWords() * visible.volume->sheetRows()),
          entries(visible.seen.table->entries()),
          strength(visible.strength) {
        const TransferTable& table = *visible.seen.table;
        const double perT = TransferTable::cells / (table.high() - table.low());
        tableScale = static_cast<float>(perT / PackedVolume::fullT);
        tableLow = static_cast<float>(1.0 - table.low() * perT);
    }
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
/// The bits that any of the words has.
HWY_INLINE WordV bitsOfAny(const Reads& reads) {
    return hn::Or(reads.low, reads.high);
}
HWY_INLINE Entries readEntries(const TransferTable::Entry* entries, IntV cell) {
    const auto& entry = entries[hn::GetLane(cell)];
    const auto set = [](float x) { return hn::Set(Floats(), x); };
    return {set(entry.value), set(entry.start), set(entry.bend), hn::Set(Words(), entry.color)};
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
/// Bits that words have, those of any lane in any.
HWY_INLINE WordV bitsOfAny(const Reads& reads) {
    return hn::Or(reads.first, reads.second);
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

#endif

/// Reads 4 bytes at byte offsets, by plain loads as well.
HWY_INLINE WordV gatherWord(const std::uint8_t* base, IntV bytes) {
#if HWY_TARGET == HWY_SCALAR
    return hn::BitCast(Words(), hn::GatherOffset(Ints(), reinterpret_cast<const std::int32_t*>(base), bytes));
#else
    return loadEach(Words(), base, LaneNumbers(bytes).values.data());
#endif
}

/// A sample is taken in three steps, so that a march can have each of them under way for another sample:
/// reads of memory take long, and the processor looks only so far ahead. First the 2 x 2 x 2 cells are read.
struct CellReads {
    Reads frontLow, frontHigh, backLow, backHigh;  ///< two along x each; low and high along y
};

HWY_INLINE CellReads readCells(const DensitySource& source, IntV offset) {
    const LaneNumbers offsets(offset);
    const auto* const back = source.words + source.sheetBytes;
    return {gather(source.words, offsets), gather(source.words + source.rowBytes, offsets),
            gather(back, offsets), gather(back + source.rowBytes, offsets)};
}

/// Where the words of a cell are, from the whole parts of its place.
HWY_INLINE IntV cellOffset(const DensitySource& source, const Whole& x, const Whole& y, const Whole& z) {
    const Words words;
    const WordV row = nearestWord(hn::MulAdd(z.value, hn::Set(Floats(), source.sheetRows), y.value));
    const WordV biased = hn::Add(hn::Mul(row, hn::Set(words, source.rowBytes)), hn::ShiftLeft<2>(x.word));
    return hn::BitCast(Ints(), hn::Sub(biased, hn::Set(words, Whole::bias * (source.rowBytes + 4U))));
}

/// What lies at a place: the cube root of extinction, and t as the cells have it.
struct Density {
    V root, t;
};

/// The two cells of a read, at a share of the way from the first to the second.
HWY_INLINE Density alongX(const WordPairs& cells, V share) {
    const Floats d;
    const Words words;
    const Ints ints;
    const WordV rootBits = hn::Set(words, 0xffff0000U), tBits = hn::Set(words, 0xffffU);
    const auto mean = [&](V low, V high) HWY_ATTR { return hn::MulAdd(share, hn::Sub(high, low), low); };
    const auto root = [&](WordV cell) HWY_ATTR { return hn::BitCast(d, hn::And(cell, rootBits)); };
    const auto t = [&](WordV cell)
                       HWY_ATTR { return hn::ConvertTo(d, hn::BitCast(ints, hn::And(cell, tBits))); };
    return {mean(root(cells.low), root(cells.high)), mean(t(cells.low), t(cells.high))};
}

HWY_INLINE Density between(const Density& low, const Density& high, V share) {
    return {hn::MulAdd(share, hn::Sub(high.root, low.root), low.root),
            hn::MulAdd(share, hn::Sub(high.t, low.t), low.t)};
}

/// In a cell; shares of the way from its first corner to its last.
HWY_INLINE Density densityIn(const CellReads& cells, V shareX, V shareY, V shareZ) {
    const auto sheet = [&](const Reads& low, const Reads& high) HWY_ATTR {
        return between(alongX(pairsOf(low), shareX), alongX(pairsOf(high), shareX), shareY);
    };
    return between(sheet(cells.frontLow, cells.frontHigh), sheet(cells.backLow, cells.backHigh), shareZ);
}

/// Then, from their t, the colours.
struct TableReads {
    V way, extinction, place;
    WordV color;
};

HWY_INLINE TableReads readTable(const DensitySource& source, V way, const Density& density) {
    const Floats d;
    const V place = hn::MulAdd(density.t, hn::Set(d, source.tableScale), hn::Set(d, source.tableLow));
    constexpr auto last = static_cast<float>(TransferTable::cells);
    const IntV entry = truncated(d, hn::Min(hn::Max(place, hn::Set(d, 1.0F)), hn::Set(d, last)));
    static_assert(sizeof(TransferTable::Entry) == 1 << 4);
    const WordV color =
        gatherWord(reinterpret_cast<const std::uint8_t*>(&source.entries->color), hn::ShiftLeft<4>(entry));
    const V root = hn::Max(density.root, hn::Zero(d));
    const V extinction = hn::Mul(hn::Mul(hn::Mul(root, root), root), hn::Set(d, source.strength));
    return {way, extinction, place, color};
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

/// Linear components of a table's colour, times 1 / colorScale.
HWY_INLINE V colorComponent(WordV root) {
    const V value = hn::ConvertTo(Floats(), hn::BitCast(Ints(), root));
    return hn::Mul(value, value);
}

/// Of a volume: its density is where its colour is in the table; extinction needs none.
HWY_INLINE Sample sampleOf(const TableReads& table) {
    const Words words;
    const WordV mask = hn::Set(words, 1023U);
    return {table.way,
            table.place,
            hn::Zero(Floats()),
            table.extinction,
            colorComponent(hn::And(table.color, mask)),
            colorComponent(hn::And(hn::ShiftRight<10>(table.color), mask)),
            colorComponent(hn::ShiftRight<20>(table.color))};
}

/// A sample of a field whose transfer function is looked up at the density itself, `rest` beyond an entry.
HWY_INLINE Sample sampleOf(V way, V density, V rest, const Entries& entry) {
    const Words words;
    const V half = hn::MulAdd(entry.bend, rest, entry.start);
    const WordV mask = hn::Set(words, 1023U);
    return {way,
            density,
            hn::MulAdd(half, rest, entry.value),
            hn::MulAdd(entry.bend, rest, half),
            colorComponent(hn::And(entry.color, mask)),
            colorComponent(hn::And(hn::ShiftRight<10>(entry.color), mask)),
            colorComponent(hn::ShiftRight<20>(entry.color))};
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
        __builtin_prefetch(source.words + source.rowBytes + offset);
        __builtin_prefetch(source.words + source.sheetBytes + offset);
        __builtin_prefetch(source.words + source.sheetBytes + source.rowBytes + offset);
    }
}

HWY_INLINE Density densityAt(const DensitySource& source, const Place& place) {
    return densityIn(readCells(source, place.offset), place.shareX, place.shareY, place.shareZ);
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
