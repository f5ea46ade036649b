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

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <type_traits>

#include "server/render/cpu/composite/truncated-inl.h"
#include "server/render/cpu/leaf_places-inl.h"
#include "server/render/cpu/point_footprint.h"
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

/// Stores the lanes of a mask side by side; returns how many. All of a vector may be written there. (What
/// AVX-512 has to pack lanes into memory takes a hundred cycles and more on AMD's processors, in a register
/// four.)
template <class D>
HWY_INLINE std::size_t storePacked(D d, hn::Vec<D> values, hn::Mask<D> chosen, hn::TFromD<D>* to) {
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX3
    hn::StoreU(hn::Compress(values, chosen), d, to);
    return hn::CountTrue(d, chosen);
#else
    return hn::CompressStore(values, chosen, d, to);
#endif
}

/// A vector of points, on the screen.
struct Projected {
    Float x, y;
    Mask seen;  ///< not nearer than the eye sees
};

/// The places of a vector of points; those from `count` on are whatever follows.
struct Places {
    Float x, y, z;
};

/// Points that loadUnguarded() may touch, from the first.
constexpr std::size_t touchedPoints = mostLanes + 1;

#if HWY_TARGET == HWY_AVX2 || HWY_TARGET == HWY_SSE4 || HWY_TARGET == HWY_SSSE3

using Bytes = hn::Repartition<std::uint8_t, Floats>;
using Pairs = hn::Repartition<std::uint64_t, Floats>;

/// The 12 bytes of two points in each block of 128 bits, the blocks two points apart.
HWY_INLINE hn::VFromD<Bytes> loadTwoEach(const PackedPosition* points) {
    const hn::Full128<std::uint8_t> block;
    const auto at = [&](std::size_t i) {
        return hn::LoadU(block, reinterpret_cast<const std::uint8_t*>(points + i));
    };
#if HWY_TARGET == HWY_AVX2
    return hn::Combine(Bytes(), at(4), at(0));
#else
    return at(0);
#endif
}

/// Shuffled to words within blocks, so no table is read: fewer steps than LoadInterleaved3 of half a vector.
HWY_INLINE Places loadUnguarded(const PackedPosition* points) {
    constexpr Bytes bytes;
    constexpr std::uint8_t no = 0x80;
    alignas(16) static constexpr std::uint8_t xy[16] = {0, 1, no, no, 6, 7, no, no,
                                                        2, 3, no, no, 8, 9, no, no};
    alignas(16) static constexpr std::uint8_t zLow[16] = {4,  5,  no, no, 10, 11, no, no,
                                                          no, no, no, no, no, no, no, no};
    alignas(16) static constexpr std::uint8_t zHigh[16] = {no, no, no, no, no, no, no, no,
                                                           4,  5,  no, no, 10, 11, no, no};
    const auto first = loadTwoEach(points), second = loadTwoEach(points + 2);
    const auto pick = [&](auto from, const std::uint8_t* which) {
        return hn::TableLookupBytesOr0(from, hn::LoadDup128(bytes, which));
    };
    constexpr Pairs pairs;
    const auto low = hn::BitCast(pairs, pick(first, xy)), high = hn::BitCast(pairs, pick(second, xy));
    const auto numbers = [](auto whole) { return hn::ConvertTo(floats, hn::BitCast(ints, whole)); };
    return {numbers(hn::InterleaveLower(pairs, low, high)), numbers(hn::InterleaveUpper(pairs, low, high)),
            numbers(hn::Or(pick(first, zLow), pick(second, zHigh)))};
}

#else

HWY_INLINE Places loadUnguarded(const PackedPosition* points) {
    hn::VFromD<Shorts> x, y, z;
    hn::LoadInterleaved3(shorts, &points->x, x, y, z);
    return {hn::ConvertTo(floats, hn::PromoteTo(ints, x)), hn::ConvertTo(floats, hn::PromoteTo(ints, y)),
            hn::ConvertTo(floats, hn::PromoteTo(ints, z))};
}

#endif

HWY_INLINE Places loadPlaces(const PackedPosition* points, const PackedPosition* end) {
    std::array<PackedPosition, touchedPoints> tail;
    if (HWY_UNLIKELY(static_cast<std::size_t>(end - points) < touchedPoints)) {
        tail = {};
        std::memcpy(tail.data(), points, static_cast<std::size_t>(end - points) * sizeof(PackedPosition));
        points = tail.data();
    }
    return loadUnguarded(points);
}

/// Where the points of leaves are read.
struct LeafSource {
    static constexpr float scale = 1.0F;      ///< of a step, over PointMap::step
    static constexpr std::size_t ahead = 12;  ///< leaves: their points lie all over the file
    const PackedPosition* points;
    const PackedPosition* end;  ///< of what may be read

    HWY_INLINE Places load(std::uint64_t begin) const { return loadPlaces(points + begin, end); }
    HWY_INLINE void prefetch(std::uint64_t begin) const {
        __builtin_prefetch(points + begin);
        __builtin_prefetch(points + begin + 10);
    }
};

/// Where those of groups are read.
struct GroupSource {
    static constexpr float scale = 1.0F / 32.0F;
    static constexpr std::size_t ahead = 4;
    const GroupedPoint* points;
    const std::uint8_t* levels = nullptr;  ///< by point, if they are shaded

    HWY_INLINE Places load(std::uint64_t begin) const {
        const hn::RebindToUnsigned<Ints> words;
        hn::VFromD<hn::RebindToUnsigned<Ints>> low, high;
        hn::LoadInterleaved2(words, &points[begin].low, low, high);
        const auto last = hn::Set(words, (1U << 21) - 1);
        const auto y = hn::Or(hn::ShiftRight<21>(low), hn::And(hn::ShiftLeft<11>(high), last));
        return {place(hn::And(low, last)), place(y), place(hn::ShiftRight<11>(high))};
    }
    HWY_INLINE void prefetch(std::uint64_t begin) const {
        HWY_UNROLL(8)
        for (std::size_t i = 0; i < 64; i += 8) __builtin_prefetch(points + begin + i);
        if (levels != nullptr) __builtin_prefetch(levels + begin);
    }

  private:
    /// Steps of leaves have their origin in the middle of the first, a 65536th of the edge.
    template <class Words>
    HWY_INLINE static Float place(Words bits) {
        return hn::ConvertTo(floats, hn::Sub(hn::BitCast(ints, bits), hn::Set(ints, 16)));
    }
};

/// A row of the map for the points of one leaf.
struct LinearRow {
    Float origin, x, y, z;
    HWY_INLINE Float operator()(const Places& places) const {
        return mulAdd(places.z, z, mulAdd(places.y, y, mulAdd(places.x, x, origin)));
    }
};

/// `scale`: of a step (LeafSource).
HWY_INLINE LinearRow linearRow(const PointMap& map, LeafCell cell, const LeafPlaces& leaves, std::size_t leaf,
                               std::size_t row, float scale = 1.0F) {
    const auto& step = map.step[cellLevel(cell)];
    return {hn::Set(floats, leaves.origin[row][leaf]), hn::Set(floats, step[0][row] * scale),
            hn::Set(floats, step[1][row] * scale), hn::Set(floats, step[2][row] * scale)};
}

/// The slab of one leaf's points, from the layer's first on.
struct SlabRow {
    LinearRow linear;
    const SlabBends& bends;

    HWY_INLINE Float operator()(const Places& places) const {
        const Float before = linear(places);
        Float slab = before;
        for (const auto& bend : bends.bends) {
            const Float at = hn::Set(floats, bend.at);
            const Float beyond =
                hn::MulAdd(hn::Sub(before, at), hn::Set(floats, bend.slope), hn::Set(floats, bend.slab));
            slab = hn::IfThenElse(hn::Gt(before, at), beyond, slab);
        }
        return slab;
    }
};

HWY_INLINE SlabRow slabRow(const PointMap& map, LeafCell cell, const LeafPlaces& leaves, std::size_t leaf,
                           float scale = 1.0F) {
    return {linearRow(map, cell, leaves, leaf, PointMap::rowSlab, scale), map.bends};
}

/// The map of one leaf's points to pixels.
template <bool perspective>
struct LeafMap {
    LinearRow x, y, w;
    Float nearest;

    HWY_INLINE LeafMap(const PointMap& map, LeafCell cell, const LeafPlaces& leaves, std::size_t leaf,
                       float scale = 1.0F)
        : x(linearRow(map, cell, leaves, leaf, PointMap::rowX, scale)),
          y(linearRow(map, cell, leaves, leaf, PointMap::rowY, scale)),
          w(linearRow(map, cell, leaves, leaf, PointMap::rowW, scale)),
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

/// How far points lie from a leaf's pixel, times w: LeafPlaces::across or down.
HWY_INLINE LinearRow distanceRow(const std::array<LeafPlaces::Numbers, 4>& steps, std::size_t leaf) {
    return {hn::Set(floats, steps[0][leaf]), hn::Set(floats, steps[1][leaf]), hn::Set(floats, steps[2][leaf]),
            hn::Set(floats, steps[3][leaf])};
}

/// How many points of a leaf fall into each of 2 x 2 pixels.
struct Quarters {
    std::uint32_t leftTop, rightTop, leftBottom, rightBottom;

    /// `leftTopCount`: among those of all pixels, in rows of `width`.
    HWY_INLINE void addTo(std::uint32_t* leftTopCount, std::size_t width) const {
        leftTopCount[0] += leftTop;
        leftTopCount[1] += rightTop;
        leftTopCount[width] += leftBottom;
        leftTopCount[width + 1] += rightBottom;
    }
};

/// A mask's bits, its first lane's the lowest.
HWY_INLINE std::uint64_t bitsOf(Mask mask) {
    // As few bytes as it has, or compilers write and read memory.
    using Bits = std::conditional_t<mostLanes <= 8, std::uint8_t,
                                    std::conditional_t<mostLanes <= 16, std::uint16_t, std::uint64_t>>;
    Bits bits = 0;
    hn::StoreMaskBits(floats, mask, reinterpret_cast<std::uint8_t*>(&bits));
    return bits;
}

/// Counts the points of a leaf that meets no more than 2 x 2 pixels: signs say which are in the second column
/// and which in the second row, whatever w.
HWY_INLINE Quarters countQuarters(const LeafPlaces& places, std::size_t leaf, const PackedPosition* points,
                                  std::size_t count, const PackedPosition* end) {
    const LinearRow across = distanceRow(places.across, leaf), down = distanceRow(places.down, leaf);
    const Float zero = hn::Zero(floats);
    std::uint32_t right = 0, below = 0, both = 0;
    for (std::size_t i = 0; i < count; i += hn::Lanes(floats)) {
        const Places at = loadPlaces(points + i, end);
        const std::uint64_t counted = ~std::uint64_t{0} >> (64 - std::min<std::size_t>(count - i, 64));
        const std::uint64_t isRight = bitsOf(hn::Ge(across(at), zero)) & counted;
        const std::uint64_t isBelow = bitsOf(hn::Ge(down(at), zero)) & counted;
        right += static_cast<std::uint32_t>(std::popcount(isRight));
        below += static_cast<std::uint32_t>(std::popcount(isBelow));
        both += static_cast<std::uint32_t>(std::popcount(isRight & isBelow));
    }
    return {static_cast<std::uint32_t>(count) - right - below + both, right - both, below - both, both};
}

/// A vector of discs, and the pixels [left, right) x [top, bottom) of a box that each may touch.
class Discs {
  public:
    /// Those of the mask.
    HWY_INLINE void set(Float x, Float y, Mask seen, float reach, const PixelBox& box) {
        count_ = storePacked(floats, x, seen, x_.data());
        storePacked(floats, y, seen, y_.data());
        // Pixel i has its centre at i + 1/2.
        const Float toCentre = hn::Set(floats, 0.5F), far = hn::Set(floats, reach);
        const auto first = [&](Float at, std::int32_t least) {
            const Float pixel = hn::Floor(hn::Add(hn::Sub(at, far), toCentre));
            return hn::Max(hn::ConvertTo(ints, pixel), hn::Set(ints, least));
        };
        const auto end = [&](Float at, std::int32_t most) {
            const Float pixel = hn::Ceil(hn::Sub(hn::Add(at, far), toCentre));
            return hn::Min(hn::Add(hn::ConvertTo(ints, pixel), hn::Set(ints, 1)), hn::Set(ints, most));
        };
        const auto mask = hn::RebindMask(ints, seen);
        storePacked(ints, first(x, box.left), mask, left_.data());
        storePacked(ints, end(x, box.right), mask, right_.data());
        storePacked(ints, first(y, box.top), mask, top_.data());
        storePacked(ints, end(y, box.bottom), mask, bottom_.data());
    }

    /// Those of some points on the screen, no more than a vector.
    HWY_INLINE void set(const ScreenPoint* points, std::size_t count, float reach, const PixelBox& box) {
        HWY_ALIGN std::array<float, mostLanes> x{}, y{};
        for (std::size_t i = 0; i < count; ++i) {
            x[i] = points[i].x;
            y[i] = points[i].y;
        }
        set(hn::Load(floats, x.data()), hn::Load(floats, y.data()), hn::FirstN(floats, count), reach, box);
    }

    HWY_INLINE std::size_t count() const { return count_; }
    HWY_INLINE float x(std::size_t i) const { return x_[i]; }
    HWY_INLINE float y(std::size_t i) const { return y_[i]; }
    HWY_INLINE PixelBox box(std::size_t i) const { return {left_[i], top_[i], right_[i], bottom_[i]}; }

  private:
    std::size_t count_ = 0;
    HWY_ALIGN std::array<float, mostLanes> x_, y_;
    HWY_ALIGN std::array<std::int32_t, mostLanes> left_, top_, right_, bottom_;
};

/// What a disc covers of a vector of pixels, in DiscFootprint::steps. `x`, `y`: how far the centres of the
/// pixels lie from its own.
HWY_INLINE Int coverageSteps(Float x, Float y, Float reach) {
    const Float distance = hn::Sqrt(hn::Add(hn::Mul(x, x), hn::Mul(y, y)));
    const Float coverage =
        hn::Min(hn::Max(hn::Sub(reach, distance), hn::Zero(floats)), hn::Set(floats, 1.0F));
    const Float steps = hn::Set(floats, static_cast<float>(DiscFootprint::steps));
    return hn::ConvertTo(ints, hn::Add(hn::Mul(coverage, steps), hn::Set(floats, 0.5F)));
}

/// Places of a vector's lanes among the pixels around them.
struct LaneOffsets {
    alignas(64) std::array<float, mostLanes> x, y;
};

/// The points of a vector that lie within a margin of a part of the picture.
struct NearBox {
    Float left, right, top, bottom;

    HWY_INLINE NearBox(const PixelBox& box, float margin)
        : left(hn::Set(floats, static_cast<float>(box.left) - margin)),
          right(hn::Set(floats, static_cast<float>(box.right) + margin)),
          top(hn::Set(floats, static_cast<float>(box.top) - margin)),
          bottom(hn::Set(floats, static_cast<float>(box.bottom) + margin)) {}

    HWY_INLINE Mask operator()(const Projected& at, Mask drawn) const {
        const Mask inX = hn::And(hn::Ge(at.x, left), hn::Le(at.x, right));
        const Mask inY = hn::And(hn::Ge(at.y, top), hn::Le(at.y, bottom));
        return hn::And(hn::And(inX, inY), hn::And(at.seen, drawn));
    }
};

/// All of a map's picture.
HWY_INLINE PixelBox pictureOf(const PointMap& map) {
    return {0, 0, static_cast<std::int32_t>(map.width), static_cast<std::int32_t>(map.height)};
}

/// A vector of preview points: their places in the whole box, whether they are drawn, and their levels.
struct PreviewPlaces {
    Places places;
    Mask drawn;
    Int level;
};

HWY_INLINE Int levelOf(const LevelLine& line, Float density) {
    const Float level = hn::MulAdd(density, hn::Set(floats, line.slope), hn::Set(floats, line.shift + 0.5F));
    const Float most = hn::Set(floats, static_cast<float>(DensityLevels::last));
    return hn::ConvertTo(ints, hn::Min(hn::Max(level, hn::Zero(floats)), most));
}

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
            hn::And(drawn, hn::FirstN(floats, run.count - i)),
            levelOf(run.levels, hn::ConvertTo(floats, hn::PromoteTo(ints, density)))};
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
