// SPDX-License-Identifier: GPL-3.0-or-later
//
// Where leaves lie on the screen, a block of them at a time.
// For the files that are compiled for each instruction set.
#if defined(MOTE_LEAF_PLACES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_LEAF_PLACES_INL_H
#undef MOTE_LEAF_PLACES_INL_H
#else
#define MOTE_LEAF_PLACES_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "server/render/cpu/point_map.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::ScalableTag<double>;
using Words = hn::RebindToUnsigned<Doubles>;
using Halves = hn::Rebind<float, Doubles>;
using Double = hn::VFromD<Doubles>;

constexpr Doubles doubles;
constexpr Words words;
constexpr Halves halves;

/// Rounded twice on every processor, so that all of them place a point alike, fused steps or not.
template <class V>
HWY_INLINE V mulAdd(V a, V b, V c) {
    return hn::Add(hn::Mul(a, b), c);
}

/// Where a block of leaves lies on the screen.
struct LeafPlaces {
    static constexpr std::size_t block = 64;
    using Numbers = std::array<float, block>;

    HWY_ALIGN std::array<Numbers, PointMap::rows> origin;  ///< of the points, by row
    HWY_ALIGN std::array<std::array<double, block>, PointMap::rows> exactOrigin;
    HWY_ALIGN Numbers edge;  ///< of the cell, of the box
    /// Pixels around all of a leaf's points; everything where the cell reaches behind the eye.
    HWY_ALIGN Numbers left, right, top, bottom;
    /// The pixel that a leaf's points are told from: the first that its cell meets or, where that meets no
    /// more than 2 x 2, the last, so that a point's sign says on which side it lies.
    HWY_ALIGN Numbers column, row;
    /// How far points lie from there, times w: at the origin and for a step along x, y and z. These numbers
    /// are no larger than the leaf, so single precision places its points to a millionth of it.
    HWY_ALIGN std::array<Numbers, 4> across, down;

    HWY_INLINE bool outside(const PointMap& map, std::size_t i, float margin) const {
        return right[i] < -margin || left[i] > static_cast<float>(map.width) + margin ||
               bottom[i] < -margin || top[i] > static_cast<float>(map.height) + margin;
    }
};

/// The cells of a vector of leaves.
struct CellVector {
    Double x, y, z;  ///< among the cells of their level
    Double edge;     ///< of the box
};

HWY_INLINE CellVector loadCells(const LeafCell* cells) {
    const auto packed = hn::LoadU(words, cells);
    // A small whole number as the low bits of a double, which is then too large by 2^52.
    constexpr double lowBits = 4503599627370496.0;
    const auto part = [&](auto shifted) {
        const auto bits =
            hn::Or(hn::And(shifted, hn::Set(words, 0xffff)), hn::BitCast(words, hn::Set(doubles, lowBits)));
        return hn::Sub(hn::BitCast(doubles, bits), hn::Set(doubles, lowBits));
    };
    const auto level = hn::And(hn::ShiftRight<48>(packed), hn::Set(words, 0x1f));
    const auto exponent = hn::Sub(hn::Set(words, 1023), level);
    return {part(packed), part(hn::ShiftRight<16>(packed)), part(hn::ShiftRight<32>(packed)),
            hn::BitCast(doubles, hn::ShiftLeft<52>(exponent))};
}

/// Places a block of leaves, in passes whose steps do not wait for each other.
template <bool perspective, bool slabs, bool told>
class LeafPlacer {
  public:
    HWY_INLINE LeafPlacer(const PointMap& map, LeafPlaces& out) : map_(map), out_(out) {}

    HWY_INLINE void place(const LeafCell* cells, std::size_t count) const {
        for (std::size_t i = 0; i < count; i += hn::Lanes(doubles)) placeOrigins(cells + i, i);
        for (std::size_t i = 0; i < count; i += hn::Lanes(numbers)) placeBounds(i);
        if constexpr (!told) return;
        for (std::size_t i = 0; i < count; i += hn::Lanes(doubles)) {
            tellOrigin(PointMap::rowX, out_.column, out_.across[0], i);
            tellOrigin(PointMap::rowY, out_.row, out_.down[0], i);
        }
    }

  private:
    using Numbers = hn::ScalableTag<float>;
    using Number = hn::VFromD<Numbers>;
    static constexpr Numbers numbers{};

    HWY_INLINE static Double exact(double value) { return hn::Set(doubles, value); }
    HWY_INLINE static Number number(double value) { return hn::Set(numbers, static_cast<float>(value)); }

    HWY_INLINE double sumOf(std::size_t row) const {
        return map_.edge[0][row] + map_.edge[1][row] + map_.edge[2][row];
    }

    HWY_INLINE void placeOrigins(const LeafCell* cells, std::size_t i) const {
        const CellVector at = loadCells(cells);
        hn::StoreU(hn::DemoteTo(halves, at.edge), halves, out_.edge.data() + i);
        HWY_UNROLL(4)
        for (std::size_t row = 0; row < PointMap::rows; ++row) {
            if (row == PointMap::rowSlab && !slabs) continue;
            Double cell = mulAdd(at.x, exact(map_.edge[0][row]), exact(0.5 / 65536.0 * sumOf(row)));
            cell = mulAdd(at.y, exact(map_.edge[1][row]), cell);
            cell = mulAdd(at.z, exact(map_.edge[2][row]), cell);
            const Double origin = mulAdd(cell, at.edge, exact(map_.corner[row]));
            if constexpr (told) hn::Store(origin, doubles, out_.exactOrigin[row].data() + i);
            hn::StoreU(hn::DemoteTo(halves, origin), halves, out_.origin[row].data() + i);
        }
    }

    /// A row's edge along an axis, told from a pixel.
    HWY_INLINE Number edgeFrom(std::size_t axis, std::size_t row, Number pixel) const {
        const Number edge = number(map_.edge[axis][row]);
        if (!perspective) return edge;
        return hn::Sub(edge, hn::Mul(pixel, number(map_.edge[axis][PointMap::rowW])));
    }

    HWY_INLINE Number middleOf(std::size_t row, Number edge, std::size_t i) const {
        return mulAdd(edge, number(0.5 * sumOf(row)), hn::Load(numbers, out_.origin[row].data() + i));
    }

    HWY_INLINE void placeBounds(std::size_t i) const {
        const Number edge = hn::Load(numbers, out_.edge.data() + i);
        Number x = middleOf(PointMap::rowX, edge, i), y = middleOf(PointMap::rowY, edge, i);
        Number reachFactor = hn::Mul(edge, number(0.5));
        auto before = hn::Eq(edge, edge);
        if constexpr (perspective) {
            const Number w = middleOf(PointMap::rowW, edge, i);
            double reachW = 0.0;
            for (const auto& side : map_.edge) reachW += 0.5 * std::abs(side[PointMap::rowW]);
            const Number front = hn::Sub(w, hn::Mul(edge, number(reachW)));
            before = hn::Gt(front, hn::Set(numbers, map_.nearest));
            reachFactor = hn::Div(reachFactor, front);
            const Number inverse = hn::Div(number(1.0), w);
            x = hn::Mul(x, inverse);
            y = hn::Mul(y, inverse);
        }
        const Number reachX = reachOf(PointMap::rowX, x, reachFactor, before);
        const Number reachY = reachOf(PointMap::rowY, y, reachFactor, before);
        const Number left = hn::Sub(x, reachX), right = hn::Add(x, reachX);
        const Number top = hn::Sub(y, reachY), bottom = hn::Add(y, reachY);
        const Number firstColumn = hn::Floor(left), firstRow = hn::Floor(top), two = number(2.0);
        const auto four =
            hn::And(hn::Lt(right, hn::Add(firstColumn, two)), hn::Lt(bottom, hn::Add(firstRow, two)));
        const Number last = hn::IfThenElseZero(four, number(1.0));
        store(left, out_.left, i);
        store(right, out_.right, i);
        store(top, out_.top, i);
        store(bottom, out_.bottom, i);
        if constexpr (!told) return;
        tellSteps(PointMap::rowX, hn::Add(firstColumn, last), edge, out_.column, out_.across, i);
        tellSteps(PointMap::rowY, hn::Add(firstRow, last), edge, out_.row, out_.down, i);
    }

    HWY_INLINE static void store(Number value, LeafPlaces::Numbers& to, std::size_t i) {
        hn::Store(value, numbers, to.data() + i);
    }

    /// How far points lie from the middle of their cell at most.
    HWY_INLINE Number reachOf(std::size_t row, Number middle, Number factor,
                              hn::MFromD<Numbers> before) const {
        Number reach = hn::Abs(edgeFrom(0, row, middle));
        reach = hn::Add(reach, hn::Abs(edgeFrom(1, row, middle)));
        reach = hn::Add(reach, hn::Abs(edgeFrom(2, row, middle)));
        return hn::IfThenElse(before, hn::Mul(reach, factor), number(1e30));
    }

    HWY_INLINE void tellSteps(std::size_t row, Number pixel, Number edge, LeafPlaces::Numbers& from,
                              std::array<LeafPlaces::Numbers, 4>& steps, std::size_t i) const {
        store(pixel, from, i);
        const Number step = hn::Mul(edge, number(1.0 / 65536.0));
        HWY_UNROLL(3)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            store(hn::Mul(edgeFrom(axis, row, pixel), step), steps[1 + axis], i);
        }
    }

    HWY_INLINE void tellOrigin(std::size_t row, const LeafPlaces::Numbers& from, LeafPlaces::Numbers& to,
                               std::size_t i) const {
        Double pixel = hn::PromoteTo(doubles, hn::LoadU(halves, from.data() + i));
        if (perspective)
            pixel = hn::Mul(pixel, hn::Load(doubles, out_.exactOrigin[PointMap::rowW].data() + i));
        const Double origin = hn::Load(doubles, out_.exactOrigin[row].data() + i);
        hn::StoreU(hn::DemoteTo(halves, hn::Sub(origin, pixel)), halves, to.data() + i);
    }

    const PointMap& map_;
    LeafPlaces& out_;
};

/// `slabs`: also how deep they lie, LeafPlaces::origin[PointMap::rowSlab]. `told`: also what their points are
/// told from, exactOrigin and from `column` on.
template <bool perspective, bool slabs = true, bool told = true>
HWY_INLINE void placeLeaves(const PointMap& map, const LeafCell* cells, std::size_t count, LeafPlaces& out) {
    HWY_ALIGN std::array<LeafCell, LeafPlaces::block> whole;
    if (count < LeafPlaces::block) {
        whole.fill(cells[0]);
        std::memcpy(whole.data(), cells, count * sizeof(LeafCell));
        cells = whole.data();
    }
    LeafPlacer<perspective, slabs, told>(map, out).place(cells, count);
}

}  // namespace
}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
