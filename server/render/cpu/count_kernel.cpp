// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/points_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/render/cpu/count_kernel.cpp"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "server/render/cpu/leaf_ways-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace {

/// The pixels of a picture, and behind them a place for each lane that shall count nowhere.
class Pixels {
  public:
    HWY_INLINE Pixels(const PointMap& map, std::uint32_t* counts)
        : counts_(counts),
          rowPixels_(hn::Set(ints, static_cast<std::int32_t>(map.width))),
          nowhere_(hn::Iota(ints, static_cast<std::int32_t>(map.width * map.height))) {}

    /// Adds one to each pixel, row by row in the picture, that a lane of the mask names.
    HWY_INLINE void add(Int pixels, Mask counted) const {
        const Int some = hn::IfThenElse(hn::RebindMask(ints, counted), pixels, nowhere_);
        const hn::RebindToUnsigned<Ints> unsignedInts;
        // Whatever rounding did, nothing else is written to.
        const auto safe = hn::Min(hn::BitCast(unsignedInts, some), hn::BitCast(unsignedInts, nowhere_));
        HWY_ALIGN std::array<std::uint32_t, mostLanes> places;
        hn::Store(safe, unsignedInts, places.data());
        HWY_UNROLL(16)
        for (std::size_t k = 0; k < hn::Lanes(ints); ++k) ++counts_[places[k]];
    }

    /// The pixels so many columns and rows (whole numbers, not beyond 2^22) from pixel `first` on.
    HWY_INLINE Int from(Int first, Float columns, Float rows) const {
        return hn::Add(hn::Add(first, wholeOf(columns)), hn::Mul(wholeOf(rows), rowPixels_));
    }

  private:
    /// Takes the number from the low bits of a sum, without the checks of a conversion.
    HWY_INLINE static Int wholeOf(Float number) {
        constexpr float lowBits = 12582912.0F;  // 1.5 * 2^23
        const Int bits = hn::BitCast(ints, hn::Add(number, hn::Set(floats, lowBits)));
        return hn::Sub(bits, hn::Set(ints, std::bit_cast<std::int32_t>(lowBits)));
    }

    std::uint32_t* counts_;
    Int rowPixels_, nowhere_;
};

/// Counts the points of a vector that fall into the picture.
struct PixelsInView {
    Pixels pixels;
    Float width, height;

    HWY_INLINE PixelsInView(const PointMap& map, std::uint32_t* counts)
        : pixels(map, counts),
          width(hn::Set(floats, static_cast<float>(map.width))),
          height(hn::Set(floats, static_cast<float>(map.height))) {}

    HWY_INLINE std::size_t count(const Projected& at, Mask drawn) const {
        const Float zero = hn::Zero(floats);
        const Mask inX = hn::And(hn::Ge(at.x, zero), hn::Lt(at.x, width));
        const Mask inY = hn::And(hn::Ge(at.y, zero), hn::Lt(at.y, height));
        const Mask seen = hn::And(hn::And(inX, inY), hn::And(at.seen, drawn));
        pixels.add(pixels.from(hn::Zero(ints), hn::Floor(at.x), hn::Floor(at.y)), seen);
        return hn::CountTrue(floats, seen);
    }
};

/// Counts the points of leaves.
template <bool perspective>
class LeafCount {
  public:
    HWY_INLINE LeafCount(const PointMap& map, const LeafRun& run, std::uint32_t* counts)
        : map_(map), run_(run), counts_(counts), pixels_(map, counts), inView_(map, counts) {}

    HWY_INLINE std::uint64_t count() {
        std::uint64_t drawn = 0;
        const PackedPosition* points = run_.points;
        for (std::size_t begin = 0; begin < run_.leaves; begin += LeafPlaces::block) {
            const std::size_t size = std::min(LeafPlaces::block, run_.leaves - begin);
            placeLeaves<perspective, false>(map_, run_.cells + begin, size, places_);
            ways_.choose(map_, places_, size);
            for (std::size_t i = 0; i < size; points += run_.count[begin + i], ++i) {
                const std::size_t count = run_.drawn[begin + i];
                if (count == 0 || ways_.way[i] == notAtAll) continue;
                drawn += count;
                countLeaf(run_.cells[begin + i], i, points, count);
            }
        }
        return drawn;
    }

  private:
    HWY_INLINE void countLeaf(LeafCell cell, std::size_t i, const PackedPosition* points, std::size_t count) {
        switch (ways_.way[i]) {
            case inOnePixel:
                counts_[ways_.first[i]] += static_cast<std::uint32_t>(count);
                break;
            case inFourPixels:
                countInFour(i, points, count);
                break;
            case inside:
                countInside(cell, i, points, count);
                break;
            default:
                countAtBorder(cell, i, points, count);
        }
    }

    HWY_INLINE void countInFour(std::size_t i, const PackedPosition* points, std::size_t count) {
        const Quarters quarters = countQuarters(places_, i, points, count, run_.end);
        std::uint32_t* const first = counts_ + ways_.first[i];
        first[0] += quarters.leftTop;
        first[1] += quarters.rightTop;
        first[map_.width] += quarters.leftBottom;
        first[map_.width + 1] += quarters.rightBottom;
    }

    HWY_INLINE void countInside(LeafCell cell, std::size_t i, const PackedPosition* points,
                                std::size_t count) {
        const LinearRow across = distanceRow(places_.across, i), down = distanceRow(places_.down, i);
        const LinearRow w = linearRow(map_, cell, places_, i, PointMap::rowW);
        // The pixel that the distances are told from; it may lie beyond the border, where no point does.
        const auto row = static_cast<std::int32_t>(places_.row[i]);
        const auto column = static_cast<std::int32_t>(places_.column[i]);
        const Int first = hn::Set(ints, row * static_cast<std::int32_t>(map_.width) + column);
        for (std::size_t k = 0; k < count; k += hn::Lanes(floats)) {
            const Places at = loadPlaces(points + k, run_.end);
            Float columns = across(at), rows = down(at);
            if constexpr (perspective) {
                const Float inverse = hn::Div(hn::Set(floats, 1.0F), w(at));
                columns = hn::Mul(columns, inverse);
                rows = hn::Mul(rows, inverse);
            }
            pixels_.add(pixels_.from(first, hn::Floor(columns), hn::Floor(rows)),
                        hn::FirstN(floats, count - k));
        }
    }

    HWY_NOINLINE void countAtBorder(LeafCell cell, std::size_t i, const PackedPosition* points,
                                    std::size_t count) {
        const LeafMap<perspective> toScreen(map_, cell, places_, i);
        for (std::size_t k = 0; k < count; k += hn::Lanes(floats)) {
            inView_.count(toScreen(loadPlaces(points + k, run_.end)), hn::FirstN(floats, count - k));
        }
    }

    const PointMap& map_;
    const LeafRun& run_;
    std::uint32_t* const counts_;
    const Pixels pixels_;
    const PixelsInView inView_;
    LeafPlaces places_;
    LeafWays ways_;
};

template <bool perspective>
std::uint64_t countLeaves(const PointMap& map, const LeafRun& run, std::uint32_t* counts) {
    return LeafCount<perspective>(map, run, counts).count();
}

std::uint64_t countPoints(const PointMap& map, const LeafRun& run, std::uint32_t* counts) {
    return map.perspective ? countLeaves<true>(map, run, counts) : countLeaves<false>(map, run, counts);
}

template <bool perspective>
std::uint64_t countPreviewOf(const PointMap& map, const PreviewRun& run, std::uint32_t* counts) {
    const PreviewMap<perspective> preview(map);
    const auto toScreen = preview.toScreen(map);
    const PixelsInView inView(map, counts);
    std::uint64_t drawn = 0;
    for (std::size_t i = 0; i < run.count; i += hn::Lanes(floats)) {
        const PreviewPlaces points = loadPreview(run, i);
        drawn += inView.count(toScreen(points.places), points.drawn);
    }
    return drawn;
}

std::uint64_t countPreview(const PointMap& map, const PreviewRun& run, std::uint32_t* counts) {
    return map.perspective ? countPreviewOf<true>(map, run, counts) : countPreviewOf<false>(map, run, counts);
}

}  // namespace
}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace mote::render {

HWY_EXPORT(countPoints);
HWY_EXPORT(countPreview);

std::uint64_t countPoints(const PointMap& map, const LeafRun& run, std::uint32_t* counts) {
    return HWY_DYNAMIC_DISPATCH(countPoints)(map, run, counts);
}

std::uint64_t countPreview(const PointMap& map, const PreviewRun& run, std::uint32_t* counts) {
    return HWY_DYNAMIC_DISPATCH(countPreview)(map, run, counts);
}

}  // namespace mote::render
#endif
