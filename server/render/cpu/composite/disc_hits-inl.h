// SPDX-License-Identifier: GPL-3.0-or-later
//
// DiscHits: discs on their way into the cells of a tile. Which packets they cover is told of sixteen discs at
// a time, and their hits (a disc, some rows of a packet) are brought together and added some hundred at once:
// in neither loop does a step wait for what another found. Compiled once for each target (Highway's
// foreach_target), hence without #pragma once.
#if defined(MOTE_DISC_HITS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_DISC_HITS_INL_H
#undef MOTE_DISC_HITS_INL_H
#else
#define MOTE_DISC_HITS_INL_H
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "server/render/cpu/point_places-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace {

/// What a disc weighs in pixels by their coverage (DiscFootprint).
struct ProportionalWeight {
    Float whole;
    ProportionalWeight(const DiscFootprint& /*disc*/, float weight) : whole(hn::Set(floats, weight)) {}
    using Begun = Float;
    HWY_INLINE static Float begin(Float coverage) { return coverage; }
    HWY_INLINE Float end(Float coverage) const { return hn::Mul(whole, coverage); }
};

/// ln(1 - opacity * coverage) / ln(1 - opacity), off by at most 3e-5 of the logarithm and 0 where nothing is
/// covered.
class OpaqueWeight {
  public:
    OpaqueWeight(const DiscFootprint& disc, float weight)
        : opacity_(hn::Set(floats, disc.opacity())),
          ofTwo_(hn::Set(floats, 0x1p-23F * 0.693147181F * weight * disc.ofLogarithm())) {
        for (std::size_t i = 0; i < series.size(); ++i)
            series_[i] = hn::Set(floats, series[i] * weight * disc.ofLogarithm());
    }

    /// What is left of light: 2^whole * (1 + u), u from sqrt(1/2) - 1 to sqrt(2) - 1.
    struct Begun {
        Float u, whole;  // 2^23 whole
    };
    HWY_INLINE Begun begin(Float coverage) const {
        const Float one = hn::Set(floats, 1.0F);
        const Int left = hn::BitCast(ints, hn::NegMulAdd(opacity_, coverage, one));
        const Int exponent = hn::And(hn::Sub(left, hn::Set(ints, 0x3f3504f3)), hn::Set(ints, -(1 << 23)));
        return {hn::Sub(hn::BitCast(floats, hn::Sub(left, exponent)), one), hn::ConvertTo(floats, exponent)};
    }
    HWY_INLINE Float end(const Begun& left) const {
        const Float u = left.u;
        Float sum = hn::MulAdd(u, series_[4], series_[3]);
        sum = hn::MulAdd(u, sum, series_[2]);
        sum = hn::MulAdd(u, sum, series_[1]);
        sum = hn::MulAdd(u, sum, series_[0]);
        return hn::MulAdd(left.whole, ofTwo_, hn::Mul(u, sum));
    }

  private:
    /// ln(1 + u) / u, interpolated at the Chebyshev nodes of its range.
    static constexpr std::array<float, 5> series{0.999962170F, -0.499502109F, 0.336687816F, -0.270102283F,
                                                 0.173486315F};
    Float opacity_, ofTwo_;
    std::array<Float, series.size()> series_;
};

/// Adds discs to the cells of one tile. `shaded`: also their levels to the shades of its pixels.
template <bool shaded>
class DiscHits {
  public:
    DiscHits(const DiscFootprint& disc, Tile tile, TileCells& cells)
        : disc_(disc),
          box_{static_cast<std::int32_t>(tile.column * Tile::edge),
               static_cast<std::int32_t>(tile.row * Tile::edge),
               static_cast<std::int32_t>((tile.column + 1) * Tile::edge),
               static_cast<std::int32_t>((tile.row + 1) * Tile::edge)},
          across_(packetsAcross(disc.reach())),
          lastSlab_(static_cast<std::int32_t>(cells.slabs()) - 1),
          cells_(cells.cells()),
          touched_(cells.touched()),
          shades_(cells.shades()) {}

    /// The pixels of the tile.
    const PixelBox& box() const { return box_; }

    /// Of what is taken from now on.
    HWY_INLINE void setWeight(float weight) {
        if (weight == weight_) return;
        finish();
        weight_ = weight;
    }

    /// Takes the discs of a mask. `slab`: 0 to the number of slabs.
    HWY_INLINE void take(Float x, Float y, Float slab, Float level, Mask seen) {
        const std::size_t taken = storePacked(floats, hn::Sub(x, number(box_.left)), seen, &x_[count_]);
        storePacked(floats, hn::Sub(y, number(box_.top)), seen, &y_[count_]);
        storePacked(floats, slab, seen, &slab_[count_]);
        if constexpr (shaded) storePacked(floats, level, seen, &level_[count_]);
        count_ += taken;
        if (count_ < together) return;
        spread(together);
        count_ -= together;
        for (auto* const each : {&x_, &y_, &slab_, &level_})
            hn::Store(hn::Load(floats, each->data() + together), floats, each->data());
    }

    /// Adds all that was taken.
    HWY_NOINLINE void finish() {
        spread(count_);
        count_ = 0;
        addHits(std::exchange(hits_, 0));
    }

  private:
    /// Discs whose packets are told together: as many whatever the width of vectors, so that a cell has the
    /// same sums.
    static constexpr std::size_t together = 16;
    static constexpr std::size_t mostHits = 256;
    static constexpr std::int32_t edge = Tile::packetEdge, rows = static_cast<std::int32_t>(mostLanes) / edge;
    static_assert(mostLanes == 4 || mostLanes == 8 || mostLanes == 16);

    /// Lanes are the pixels of a packet's rows in such an order that weights and depths, interleaved within
    /// blocks of 128 bits, are cells in theirs.
    static constexpr LaneOffsets offsets = [] {
        LaneOffsets made{};
        for (std::size_t lane = 0; lane < mostLanes; ++lane) {
            const std::size_t block = lane / 4, inside = lane % 4;
            const std::size_t pixel = (inside < 2 ? 0 : mostLanes / 2) + 2 * block + inside % 2;
            const std::size_t row = pixel / edge;
            made.x[lane] = static_cast<float>(pixel % edge) + 0.5F;
            made.y[lane] = static_cast<float>(row) + 0.5F;
        }
        return made;
    }();

    HWY_INLINE static Float number(std::int32_t value) { return hn::Set(floats, static_cast<float>(value)); }

    /// The most packets that a disc may touch along an axis of a tile: so many pixels have their centres
    /// nearer than its reach.
    static std::int32_t packetsAcross(float reach) {
        const auto pixels = static_cast<std::int32_t>(std::ceil(2.0F * std::min(reach, 64.0F)));
        return std::min((pixels + 2) / edge + 1, static_cast<std::int32_t>(Tile::edge) / edge);
    }

    /// Where discs lie from the first pixel of some pixels along an axis, and the square of how far from the
    /// nearest one's centre.
    struct Along {
        HWY_ALIGN std::array<float, together> from, square;

        /// From pixel `first` on; `there`: else they are far from all.
        HWY_INLINE void set(std::size_t i, Float at, Float first, std::int32_t pixels, Mask there) {
            const Float inside = hn::Sub(at, first);
            const Float nearest = hn::Min(hn::Max(hn::Floor(inside), hn::Zero(floats)), number(pixels - 1));
            const Float away = hn::Sub(inside, hn::Add(nearest, hn::Set(floats, 0.5F)));
            const Float far = hn::Set(floats, 1e30F);
            hn::Store(inside, floats, &from[i]);
            hn::Store(hn::IfThenElse(there, hn::Mul(away, away), far), floats, &square[i]);
        }
    };
    /// In which cells discs lie.
    struct Cells {
        HWY_ALIGN std::array<std::int32_t, together> first;  // of the first packet that each may touch
        HWY_ALIGN std::array<float, together> place;         // how deep in the slab
    };
    static constexpr std::int32_t tilePackets = static_cast<std::int32_t>(Tile::edge) / edge;

    /// Brings the hits of the first discs together: packet by packet from the first one that each may touch,
    /// and there some rows at a time.
    HWY_INLINE void spread(std::size_t count) {
        std::array<Along, tilePackets> columns;
        Along rowsAlong;
        std::size_t hits = hits_;  // not the member: what vectors write might be any
        Cells cells;
        for (std::size_t i = 0; i < count; i += hn::Lanes(floats)) {
            const Float x = hn::Load(floats, &x_[i]), first = firstPacket(x);
            for (std::int32_t column = 0; column < across_; ++column)
                setAlong(columns[static_cast<std::size_t>(column)], i, x, first, column, 0, edge, count);
            setCells(cells, i, first);
        }
        for (std::int32_t row = 0; row < across_; ++row) {
            for (std::int32_t part = 0; part < edge; part += rows) {
                for (std::size_t i = 0; i < count; i += hn::Lanes(floats)) {
                    const Float y = hn::Load(floats, &y_[i]);
                    setAlong(rowsAlong, i, y, firstPacket(y), row, part, rows, count);
                }
                for (std::int32_t column = 0; column < across_; ++column) {
                    const std::int32_t cell =
                        (row * tilePackets + column) * static_cast<std::int32_t>(Tile::packetPixels) +
                        part * edge;
                    for (std::size_t i = 0; i < count; i += hn::Lanes(floats))
                        hits +=
                            hit(i, columns[static_cast<std::size_t>(column)], rowsAlong, cells, cell, hits);
                    if (HWY_UNLIKELY(hits > mostHits)) addHits(std::exchange(hits, 0));
                }
            }
        }
        hits_ = hits;
    }

    /// Along an axis of the tile, the packet of the first pixel whose centre, at i + 1/2, is not before what
    /// discs reach.
    HWY_INLINE Float firstPacket(Float at) const {
        const Float first = hn::Sub(at, hn::Set(floats, disc_.reach() - 0.5F));
        return hn::Max(hn::Floor(hn::Mul(hn::Floor(first), hn::Set(floats, 1.0F / edge))), hn::Zero(floats));
    }
    /// In the packet that is `behind` the first, from pixel `part` on.
    HWY_INLINE static void setAlong(Along& along, std::size_t i, Float at, Float first, std::int32_t behind,
                                    std::int32_t part, std::int32_t pixels, std::size_t count) {
        const Float packet = hn::Add(first, number(behind));
        const Mask there = hn::And(hn::Lt(packet, number(tilePackets)), hn::FirstN(floats, count - i));
        along.set(i, at, hn::MulAdd(packet, number(edge), number(part)), pixels, there);
    }
    HWY_INLINE void setCells(Cells& cells, std::size_t i, Float firstColumn) const {
        static_assert(Tile::packetPixels == 16 && Tile::pixels == 1 << 10 && tilePackets == 8);
        const Float firstRow = firstPacket(hn::Load(floats, &y_[i])), slab = hn::Load(floats, &slab_[i]);
        const Int slabIndex = hn::Min(truncated(floats, slab), hn::Set(ints, lastSlab_));
        const Int packet =
            hn::Add(hn::ShiftLeft<3>(truncated(floats, firstRow)), truncated(floats, firstColumn));
        hn::Store(hn::Add(hn::ShiftLeft<10>(slabIndex), hn::ShiftLeft<4>(packet)), ints, &cells.first[i]);
        hn::Store(hn::Sub(slab, hn::ConvertTo(floats, slabIndex)), floats, &cells.place[i]);
    }

    /// A vector of discs in so many pixels, the first of which is `cell` behind that of their first packet.
    HWY_INLINE std::size_t hit(std::size_t i, const Along& column, const Along& row, const Cells& cells,
                               std::int32_t cell, std::size_t at) {
        const auto load = [i](const auto& each) HWY_ATTR { return hn::Load(floats, &each[i]); };
        const Float reach = hn::Set(floats, disc_.reach());
        const Mask hits = hn::Lt(hn::Add(load(column.square), load(row.square)), hn::Mul(reach, reach));
        const Int cellOf = hn::Add(hn::Load(ints, &cells.first[i]), hn::Set(ints, cell));
        const std::size_t found = storePacked(ints, cellOf, hn::RebindMask(ints, hits), &hitCell_[at]);
        storePacked(floats, load(column.from), hits, &hitX_[at]);
        storePacked(floats, load(row.from), hits, &hitY_[at]);
        storePacked(floats, load(cells.place), hits, &hitPlace_[at]);
        if constexpr (shaded) storePacked(floats, load(level_), hits, &hitLevel_[at]);
        return found;
    }

    HWY_NOINLINE void addHits(std::size_t size) const {
        if (disc_.proportional()) {
            addHits(ProportionalWeight(disc_, shaded ? 1.0F : weight_), size);
        } else {
            addHits(OpaqueWeight(disc_, shaded ? 1.0F : weight_), size);
        }
    }
    template <class WeightOf>
    HWY_INLINE void addHits(const WeightOf& weightOf, std::size_t size) const {
        // Some at a time, step by step: one by one, each would wait for its own square roots and logarithms.
        constexpr std::size_t some = 4;
        std::size_t i = 0;
        for (; i + some <= size; i += some) addSome(weightOf, i, std::make_index_sequence<some>());
        for (; i < size; ++i) addSome(weightOf, i, std::make_index_sequence<1>());
    }
    template <class WeightOf, std::size_t... k>
    HWY_INLINE void addSome(const WeightOf& weightOf, std::size_t first, std::index_sequence<k...>) const {
        using Some = std::array<Float, sizeof...(k)>;
        const Some squares{squareOf(first + k)...};
        const Some coverages{coverageOf(squares[k])...};
        const std::array<typename WeightOf::Begun, sizeof...(k)> begun{weightOf.begin(coverages[k])...};
        const Some weights{weightOf.end(begun[k])...};
        (addOne(first + k, weights[k]), ...);
    }
    /// Of the distance between a disc's centre and each pixel's.
    HWY_INLINE Float squareOf(std::size_t hit) const {
        const Float dx = hn::Sub(hn::Load(floats, offsets.x.data()), hn::Set(floats, hitX_[hit]));
        const Float dy = hn::Sub(hn::Load(floats, offsets.y.data()), hn::Set(floats, hitY_[hit]));
        return mulAdd(dx, dx, hn::Mul(dy, dy));
    }
    HWY_INLINE Float coverageOf(Float square) const {
        const Float inside = hn::Sub(hn::Set(floats, disc_.reach()), hn::Sqrt(square));
        return hn::Min(hn::Max(inside, hn::Zero(floats)), hn::Set(floats, 1.0F));
    }
    HWY_INLINE void addOne(std::size_t hit, Float covered) const {
        const auto cell = static_cast<std::uint32_t>(hitCell_[hit]);
        touched_[cell / Tile::packetPixels] = 1;
        const Float place = hn::Set(floats, hitPlace_[hit]);
        if constexpr (shaded) {
            addTo(&cells_[cell].weight, hn::Mul(hn::Set(floats, weight_), covered), place);
            addTo(&shades_[cell % Tile::pixels].weight, covered, hn::Set(floats, hitLevel_[hit]));
        } else {
            addTo(&cells_[cell].weight, covered, place);
        }
    }

    /// Pairs of weights and of weights times a number.
    HWY_INLINE static void addTo(float* sums, Float weight, Float times) {
        static_assert(sizeof(PointCell) == 2 * sizeof(float) && sizeof(PixelShade) == 2 * sizeof(float));
        const Float depth = hn::Mul(weight, times);
        const auto add = [](float* to, Float what)
                             HWY_ATTR { hn::StoreU(hn::Add(hn::LoadU(floats, to), what), floats, to); };
        add(sums, hn::InterleaveLower(floats, weight, depth));
        add(sums + mostLanes, hn::InterleaveUpper(floats, weight, depth));
    }

    const DiscFootprint& disc_;
    const PixelBox box_;
    const std::int32_t across_;
    const std::int32_t lastSlab_;
    PointCell* const cells_;
    std::uint8_t* const touched_;
    PixelShade* const shades_;
    float weight_ = 1.0F;
    std::size_t count_ = 0, hits_ = 0;
    // Discs that were taken: their places in the tile.
    using Taken = std::array<float, together + mostLanes>;
    HWY_ALIGN Taken x_{}, y_{}, slab_{}, level_{};
    // Hits: the first cell, the disc's centre from the first pixel's corner, how deep in the slab.
    template <class T>
    using Hits = std::array<T, mostHits + together + mostLanes>;
    Hits<std::int32_t> hitCell_;
    Hits<float> hitX_, hitY_, hitPlace_, hitLevel_;
};

}  // namespace
}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
