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

/// Where a block of leaves lies on the screen.
struct LeafPlaces {
    static constexpr std::size_t block = 64;

    HWY_ALIGN std::array<std::array<float, block>, PointMap::rows> origin;  ///< of the points, by row
    /// Pixels around all of a leaf's points; everything where the cell reaches behind the eye.
    HWY_ALIGN std::array<float, block> left, right, top, bottom;

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
    const auto part = [&](auto shifted) {
        return hn::ConvertTo(
            doubles, hn::BitCast(hn::RebindToSigned<Doubles>(), hn::And(shifted, hn::Set(words, 0xffff))));
    };
    const auto level = hn::And(hn::ShiftRight<48>(packed), hn::Set(words, 0x1f));
    const auto exponent = hn::Sub(hn::Set(words, 1023), level);
    return {part(packed), part(hn::ShiftRight<16>(packed)), part(hn::ShiftRight<32>(packed)),
            hn::BitCast(doubles, hn::ShiftLeft<52>(exponent))};
}

/// Fills in places [i, i + lanes of doubles).
template <bool perspective>
HWY_INLINE void placeVector(const PointMap& map, const LeafCell* cells, std::size_t i, LeafPlaces& out) {
    const CellVector at = loadCells(cells + i);
    const auto constant = [](double value) { return hn::Set(doubles, value); };
    const auto store = [&](Double value, std::array<float, LeafPlaces::block>& to) {
        hn::StoreU(hn::DemoteTo(halves, value), halves, to.data() + i);
    };
    Double middle[PointMap::rows];
    for (std::size_t row = 0; row < PointMap::rows; ++row) {
        const double sum = map.edge[0][row] + map.edge[1][row] + map.edge[2][row];
        Double cell = hn::MulAdd(at.x, constant(map.edge[0][row]), constant(0.5 / 65536.0 * sum));
        cell = hn::MulAdd(at.y, constant(map.edge[1][row]), cell);
        cell = hn::MulAdd(at.z, constant(map.edge[2][row]), cell);
        const Double origin = hn::MulAdd(cell, at.edge, constant(map.corner[row]));
        store(origin, out.origin[row]);
        middle[row] = hn::MulAdd(at.edge, constant(0.5 * sum), origin);
    }
    const auto reachOf = [&](std::size_t row, Double pixel) {
        Double reach = hn::Zero(doubles);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const Double cross = perspective ? hn::NegMulAdd(pixel, constant(map.edge[axis][PointMap::rowW]),
                                                             constant(map.edge[axis][row]))
                                             : constant(map.edge[axis][row]);
            reach = hn::Add(reach, hn::Abs(cross));
        }
        return hn::Mul(reach, hn::Mul(at.edge, constant(0.5)));
    };
    Double x = middle[PointMap::rowX], y = middle[PointMap::rowY];
    Double reachX, reachY;
    if constexpr (perspective) {
        const Double inverse = hn::Div(constant(1.0), middle[PointMap::rowW]);
        x = hn::Mul(x, inverse);
        y = hn::Mul(y, inverse);
        double reachW = 0.0;
        for (std::size_t axis = 0; axis < 3; ++axis) reachW += 0.5 * std::abs(map.edge[axis][PointMap::rowW]);
        const Double front = hn::NegMulAdd(at.edge, constant(reachW), middle[PointMap::rowW]);
        const auto before = hn::Gt(front, constant(map.nearest));
        const Double nearest = hn::Div(constant(1.0), front);
        const Double everything = constant(1e30);
        reachX = hn::IfThenElse(before, hn::Mul(reachOf(PointMap::rowX, x), nearest), everything);
        reachY = hn::IfThenElse(before, hn::Mul(reachOf(PointMap::rowY, y), nearest), everything);
    } else {
        reachX = reachOf(PointMap::rowX, x);
        reachY = reachOf(PointMap::rowY, y);
    }
    store(hn::Sub(x, reachX), out.left);
    store(hn::Add(x, reachX), out.right);
    store(hn::Sub(y, reachY), out.top);
    store(hn::Add(y, reachY), out.bottom);
}

template <bool perspective>
HWY_INLINE void placeLeaves(const PointMap& map, const LeafCell* cells, std::size_t count, LeafPlaces& out) {
    HWY_ALIGN std::array<LeafCell, LeafPlaces::block> whole;
    if (count < LeafPlaces::block) {
        whole.fill(cells[0]);
        std::memcpy(whole.data(), cells, count * sizeof(LeafCell));
        cells = whole.data();
    }
    const std::size_t lanes = hn::Lanes(doubles);
    for (std::size_t i = 0; i < count; i += lanes) placeVector<perspective>(map, cells, i, out);
}

}  // namespace
}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
