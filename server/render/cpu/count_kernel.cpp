// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/points_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/render/cpu/count_kernel.cpp"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "server/render/cpu/point_places-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace {

/// Counts the points of a vector that fall into the picture.
struct PixelsInView {
    Float width, height;
    Int rowPixels;

    HWY_INLINE explicit PixelsInView(const PointMap& map)
        : width(hn::Set(floats, static_cast<float>(map.width))),
          height(hn::Set(floats, static_cast<float>(map.height))),
          rowPixels(hn::Set(ints, static_cast<std::int32_t>(map.width))) {}

    HWY_INLINE std::size_t count(const Projected& at, Mask drawn, std::uint32_t* counts) const {
        const Float zero = hn::Zero(floats);
        const Mask inX = hn::And(hn::Ge(at.x, zero), hn::Lt(at.x, width));
        const Mask inY = hn::And(hn::Ge(at.y, zero), hn::Lt(at.y, height));
        const Mask seen = hn::And(hn::And(inX, inY), hn::And(at.seen, drawn));
        const Int row = hn::Mul(hn::ConvertTo(ints, at.y), rowPixels);
        const Int pixel = hn::Add(row, hn::ConvertTo(ints, at.x));
        HWY_ALIGN std::array<std::int32_t, mostLanes> pixels;
        const std::size_t hits = hn::CompressStore(pixel, hn::RebindMask(ints, seen), ints, pixels.data());
        for (std::size_t k = 0; k < hits; ++k) ++counts[pixels[k]];
        return hits;
    }
};

/// A leaf whose cell meets at most 2 x 2 pixels of the picture.
template <bool perspective>
HWY_INLINE void countInFour(const PointMap& map, const LeafMap<perspective>& toScreen, const LeafRun& run,
                            const PackedPosition* points, std::size_t count, float left, float top,
                            std::uint32_t* counts) {
    const Quarters quarters = countQuarters(toScreen, points, count, run.end, left, top);
    std::uint32_t* const first =
        counts + static_cast<std::size_t>(top) * map.width + static_cast<std::size_t>(left);
    first[0] += quarters.leftTop;
    first[1] += quarters.rightTop;
    first[map.width] += quarters.leftBottom;
    first[map.width + 1] += quarters.rightBottom;
}

template <bool perspective>
HWY_INLINE void countEach(const PixelsInView& inView, const LeafMap<perspective>& toScreen,
                          const LeafRun& run, const PackedPosition* points, std::size_t count,
                          std::uint32_t* counts) {
    for (std::size_t i = 0; i < count; i += hn::Lanes(floats)) {
        const Projected at = toScreen(loadPlaces(points + i, run.end));
        inView.count(at, hn::FirstN(floats, count - i), counts);
    }
}

template <bool perspective>
std::uint64_t countLeaves(const PointMap& map, const LeafRun& run, std::uint32_t* counts) {
    std::uint64_t drawn = 0;
    const PackedPosition* points = run.points;
    const auto width = static_cast<float>(map.width), height = static_cast<float>(map.height);
    const PixelsInView inView(map);
    LeafPlaces places;
    for (std::size_t begin = 0; begin < run.leaves; begin += LeafPlaces::block) {
        const std::size_t size = std::min(LeafPlaces::block, run.leaves - begin);
        placeLeaves<perspective>(map, run.cells + begin, size, places);
        for (std::size_t i = 0; i < size; points += run.count[begin + i], ++i) {
            const std::size_t count = run.drawn[begin + i];
            if (count == 0 || places.outside(map, i, 0.0F)) continue;
            drawn += count;
            const LeafMap<perspective> toScreen(map, run.cells[begin + i], places, i);
            const float left = std::floor(places.left[i]), top = std::floor(places.top[i]);
            if (places.right[i] < left + 2.0F && places.bottom[i] < top + 2.0F && left >= 0.0F &&
                top >= 0.0F && left + 2.0F <= width && top + 2.0F <= height) {
                countInFour(map, toScreen, run, points, count, left, top, counts);
            } else {
                countEach(inView, toScreen, run, points, count, counts);
            }
        }
    }
    return drawn;
}

std::uint64_t countPoints(const PointMap& map, const LeafRun& run, std::uint32_t* counts) {
    return map.perspective ? countLeaves<true>(map, run, counts) : countLeaves<false>(map, run, counts);
}

template <bool perspective>
std::uint64_t countPreviewOf(const PointMap& map, const PreviewRun& run, std::uint32_t* counts) {
    const PreviewMap<perspective> preview(map);
    const auto toScreen = preview.toScreen(map);
    const PixelsInView inView(map);
    std::uint64_t drawn = 0;
    for (std::size_t i = 0; i < run.count; i += hn::Lanes(floats)) {
        const PreviewPlaces points = loadPreview(run, i);
        drawn += inView.count(toScreen(points.places), points.drawn, counts);
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
