// SPDX-License-Identifier: GPL-3.0-or-later
//
// Where points lie on the screen, a vector of them at a time.
// For the files that are compiled for each instruction set.
#if defined(MOTE_POINT_PLACES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_POINT_PLACES_INL_H
#undef MOTE_POINT_PLACES_INL_H
#else
#define MOTE_POINT_PLACES_INL_H
#endif

#include <hwy/highway.h>

#include <array>
#include <cstring>

#include "server/render/cpu/leaf_places-inl.h"
#include "server/render/cpu/points_kernel.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace {

using storage::PackedPosition;

using Floats = hn::ScalableTag<float>;
using Ints = hn::RebindToSigned<Floats>;
using Shorts = hn::Rebind<std::uint16_t, Floats>;
using Float = hn::VFromD<Floats>;
using Int = hn::VFromD<Ints>;
using Mask = hn::MFromD<Floats>;

constexpr Floats floats;
constexpr Ints ints;
constexpr Shorts shorts;
constexpr std::size_t mostLanes = HWY_MAX_BYTES / sizeof(float);

/// A vector of points, on the screen.
struct Projected {
    Float x, y;
    Mask seen;  ///< not nearer than the eye sees
};

/// The places of a vector of points; those from `count` on are whatever follows.
struct Places {
    Float x, y, z;
};

HWY_INLINE Places loadPlaces(const PackedPosition* points, const PackedPosition* end) {
    const std::size_t lanes = hn::Lanes(floats);
    std::array<PackedPosition, mostLanes> tail;
    if (HWY_UNLIKELY(points + lanes > end)) {
        tail = {};
        std::memcpy(tail.data(), points, static_cast<std::size_t>(end - points) * sizeof(PackedPosition));
        points = tail.data();
    }
    hn::VFromD<Shorts> x, y, z;
    hn::LoadInterleaved3(shorts, &points->x, x, y, z);
    return {hn::ConvertTo(floats, hn::PromoteTo(ints, x)), hn::ConvertTo(floats, hn::PromoteTo(ints, y)),
            hn::ConvertTo(floats, hn::PromoteTo(ints, z))};
}

/// A row of the map for the points of one leaf.
struct LinearRow {
    Float origin, x, y, z;
    HWY_INLINE Float operator()(const Places& places) const {
        return hn::MulAdd(places.z, z, hn::MulAdd(places.y, y, hn::MulAdd(places.x, x, origin)));
    }
};

HWY_INLINE LinearRow linearRow(const PointMap& map, LeafCell cell, const LeafPlaces& leaves, std::size_t leaf,
                               std::size_t row) {
    const auto& step = map.step[cellLevel(cell)];
    return {hn::Set(floats, leaves.origin[row][leaf]), hn::Set(floats, step[0][row]),
            hn::Set(floats, step[1][row]), hn::Set(floats, step[2][row])};
}

/// The slab of one leaf's points, from the layer's first on.
struct SlabRow {
    LinearRow linear;
    const SlabBends& bends;

    HWY_INLINE Float operator()(const Places& places) const {
        const Float before = linear(places);
        Float slab = before;
        for (const auto& bend : bends.bends) {
            const Float beyond = hn::Max(hn::Sub(before, hn::Set(floats, bend.at)), hn::Zero(floats));
            slab = hn::MulAdd(hn::Set(floats, bend.turn), beyond, slab);
        }
        return slab;
    }
};

HWY_INLINE SlabRow slabRow(const PointMap& map, LeafCell cell, const LeafPlaces& leaves, std::size_t leaf) {
    return {linearRow(map, cell, leaves, leaf, PointMap::rowSlab), map.bends};
}

/// The map of one leaf's points to pixels.
template <bool perspective>
struct LeafMap {
    LinearRow x, y, w;
    Float nearest;

    HWY_INLINE LeafMap(const PointMap& map, LeafCell cell, const LeafPlaces& leaves, std::size_t leaf)
        : x(linearRow(map, cell, leaves, leaf, PointMap::rowX)),
          y(linearRow(map, cell, leaves, leaf, PointMap::rowY)),
          w(linearRow(map, cell, leaves, leaf, PointMap::rowW)),
          nearest(hn::Set(floats, map.nearest)) {}

    HWY_INLINE Projected operator()(const Places& places) const {
        if constexpr (perspective) {
            const Float depth = w(places);
            const Float inverse = hn::Div(hn::Set(floats, 1.0F), depth);
            return {hn::Mul(x(places), inverse), hn::Mul(y(places), inverse), hn::Ge(depth, nearest)};
        } else {
            return {x(places), y(places), hn::Eq(nearest, nearest)};
        }
    }
};

/// How many points of a leaf fall into each of 2 x 2 pixels.
struct Quarters {
    std::uint32_t leftTop, rightTop, leftBottom, rightBottom;
};

/// Of points that all fall into the pixels whose first is (left, top): those right of the middle border and
/// those below it are counted, a vector at a time.
template <bool perspective>
HWY_INLINE Quarters countQuarters(const LeafMap<perspective>& toScreen, const PackedPosition* points,
                                  std::size_t count, const PackedPosition* end, float left, float top) {
    const Float borderX = hn::Set(floats, left + 1.0F), borderY = hn::Set(floats, top + 1.0F);
    std::size_t right = 0, below = 0, both = 0;
    for (std::size_t i = 0; i < count; i += hn::Lanes(floats)) {
        const Projected at = toScreen(loadPlaces(points + i, end));
        const Mask counted = hn::FirstN(floats, count - i);
        const Mask isRight = hn::And(hn::Ge(at.x, borderX), counted);
        const Mask isBelow = hn::And(hn::Ge(at.y, borderY), counted);
        right += hn::CountTrue(floats, isRight);
        below += hn::CountTrue(floats, isBelow);
        both += hn::CountTrue(floats, hn::And(isRight, isBelow));
    }
    return {static_cast<std::uint32_t>(count - right - below + both),
            static_cast<std::uint32_t>(right - both), static_cast<std::uint32_t>(below - both),
            static_cast<std::uint32_t>(both)};
}

/// A vector of preview points: their places in the whole box, and whether they are drawn.
struct PreviewPlaces {
    Places places;
    Mask drawn;
};

HWY_INLINE PreviewPlaces loadPreview(const PreviewRun& run, std::size_t i) {
    const std::size_t lanes = hn::Lanes(floats);
    const storage::PreviewPoint* points = run.points + i;
    std::array<storage::PreviewPoint, mostLanes> tail;
    if (HWY_UNLIKELY(i + lanes > run.count)) {
        tail = {};
        std::memcpy(tail.data(), points, (run.count - i) * sizeof(storage::PreviewPoint));
        points = tail.data();
    }
    hn::VFromD<Shorts> x, y, z, density;
    hn::LoadInterleaved4(shorts, &points->x, x, y, z, density);
    const Int index = hn::PromoteTo(ints, hn::ShiftRight<PreviewSelection::densityShift>(density));
    const Mask drawn = hn::Ge(hn::GatherIndex(floats, run.limit, index), hn::Set(floats, run.threshold));
    return {{hn::ConvertTo(floats, hn::PromoteTo(ints, x)), hn::ConvertTo(floats, hn::PromoteTo(ints, y)),
             hn::ConvertTo(floats, hn::PromoteTo(ints, z))},
            hn::And(drawn, hn::FirstN(floats, run.count - i))};
}

/// The map of the preview's points, whose cell is the whole box.
template <bool perspective>
struct PreviewMap {
    static constexpr LeafCell whole = 0;
    LeafPlaces box;

    explicit PreviewMap(const PointMap& map) { placeLeaves<perspective>(map, &whole, 1, box); }
    HWY_INLINE LeafMap<perspective> toScreen(const PointMap& map) const { return {map, whole, box, 0}; }
    HWY_INLINE SlabRow toSlab(const PointMap& map) const { return slabRow(map, whole, box, 0); }
};

}  // namespace
}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
