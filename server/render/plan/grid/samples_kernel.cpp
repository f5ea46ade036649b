// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/grid/volume_samples.h"

#include <cstdint>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/render/plan/grid/samples_kernel.cpp"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using Floats = hn::CappedTag<float, SamplePlaces::together>;
using Ints = hn::RebindToSigned<Floats>;
constexpr Floats floats;
constexpr Ints ints;
using Float = hn::VFromD<Floats>;
using Int = hn::VFromD<Ints>;
using Mask = hn::Mask<Floats>;

HWY_INLINE Float setFloat(float value) {
    return hn::Set(floats, value);
}
HWY_INLINE Int setInt(std::uint32_t value) {
    return hn::Set(ints, static_cast<std::int32_t>(value));
}
HWY_INLINE Float held(Float value, float most) {
    return hn::Min(hn::Max(value, hn::Zero(floats)), setFloat(most));
}
HWY_INLINE Float mix(Float from, Float to, Float share) {
    return hn::Add(from, hn::Mul(share, hn::Sub(to, from)));
}

/// Places along one axis of a grid: the samples before them, and how far they are to the next ones.
struct AxisPlaces {
    Int below;
    Float share;
    Int next;  ///< 1, or 0 behind the last sample

    HWY_INLINE AxisPlaces(Float at, float last)
        : below(hn::ConvertTo(ints, at)), share(hn::Sub(at, hn::ConvertTo(floats, below))) {
        next = hn::IfThenElseZero(hn::RebindMask(ints, hn::Lt(at, setFloat(last))), setInt(1));
    }
};

HWY_INLINE Int wordsAt(const std::uint16_t* samples, Int index) {
    return hn::GatherOffset(ints, reinterpret_cast<const std::int32_t*>(samples), hn::Add(index, index));
}

/// Between eight samples. `first`: where the grid or brick begins in memory.
HWY_INLINE Float between(const std::uint16_t* samples, Int first, const AxisPlaces& x, const AxisPlaces& y,
                         const AxisPlaces& z, std::uint32_t row, std::uint32_t sheet) {
    const Int down = setInt(row), back = setInt(sheet);
    const Int own = hn::Add(hn::Add(first, x.below), hn::Add(hn::Mul(y.below, down), hn::Mul(z.below, back)));
    const Int nextRow = hn::Mul(y.next, down), nextSheet = hn::Mul(z.next, back);
    // Behind the last sample of a row is another one, of which there is a share of 0.
    const auto two = [&](Int at) HWY_ATTR {
        const Int words = wordsAt(samples, at);
        const Float from = hn::ConvertTo(floats, hn::And(words, setInt(0xffff)));
        const Float to = hn::ConvertTo(
            floats, hn::BitCast(ints, hn::ShiftRight<16>(hn::BitCast(hn::RebindToUnsigned<Ints>(), words))));
        return mix(from, to, x.share);
    };
    const Int behind = hn::Add(own, nextSheet);
    const Float front = mix(two(own), two(hn::Add(own, nextRow)), y.share);
    return mix(front, mix(two(behind), two(hn::Add(behind, nextRow)), y.share), z.share);
}

struct Places {
    Float x, y, z;
};

HWY_INLINE Float coarseCodes(const SampleGrids& grids, const Places& places) {
    const auto axis = [&](Float place, int i) HWY_ATTR {
        const float last = grids.coarseLast[i];
        const Float at = hn::Sub(hn::Mul(place, setFloat(grids.coarseScale[i])), setFloat(0.5F));
        return AxisPlaces(held(at, last), last);
    };
    const glm::uvec3& size = grids.coarse->size;
    return between(grids.coarse->values.data(), hn::Zero(ints), axis(places.x, 0), axis(places.y, 1),
                   axis(places.z, 2), size.x, size.x * size.y);
}

/// In corrected bricks, elsewhere in the coarse grid.
HWY_INLINE Float codesAt(const SampleGrids& grids, const Places& places) {
    if (grids.bricks == nullptr) return coarseCodes(grids, places);
    const GridBricks& bricks = *grids.bricks;
    const auto sample = [&](Float place, int i)
                            HWY_ATTR { return held(hn::Sub(place, setFloat(0.5F)), grids.last[i]); };
    const Float x = sample(places.x, 0), y = sample(places.y, 1), z = sample(places.z, 2);
    static_assert(GridBricks::edge == 8);
    const auto brick = [](Float at) HWY_ATTR { return hn::ShiftRight<3>(hn::ConvertTo(ints, at)); };
    const Int column = brick(x), row = brick(y), sheet = brick(z);
    const Int rows = hn::Add(hn::Mul(sheet, setInt(bricks.count.y)), row);
    const Int number =
        hn::GatherIndex(ints, bricks.numbers.data(), hn::Add(hn::Mul(rows, setInt(bricks.count.x)), column));
    const Mask fine = hn::RebindMask(floats, hn::Gt(number, hn::Set(ints, GridBricks::none)));
    if (hn::AllFalse(floats, fine)) return coarseCodes(grids, places);
    const auto axis = [](Float at, Int first) HWY_ATTR {
        const Float corner = hn::ConvertTo(floats, hn::ShiftLeft<3>(first));
        return AxisPlaces(hn::Sub(at, corner), static_cast<float>(GridBricks::edge));
    };
    constexpr std::uint32_t across = GridBricks::samples;
    const Int first = hn::Mul(hn::Max(number, hn::Zero(ints)), setInt(GridBricks::volume));
    const Float found = between(bricks.values.data(), first, axis(x, column), axis(y, row), axis(z, sheet),
                                across, across * across);
    return hn::AllTrue(floats, fine) ? found : hn::IfThenElse(fine, found, coarseCodes(grids, places));
}

void sampleCodes(const SampleGrids& grids, const SamplePlaces& places, SampleCodes& codes) {
    for (std::size_t i = 0; i < places.size; i += hn::Lanes(floats)) {
        const auto load = [&](const auto& list) HWY_ATTR { return hn::LoadU(floats, list.data() + i); };
        hn::StoreU(codesAt(grids, {load(places.x), load(places.y), load(places.z)}), floats,
                   codes.data() + i);
    }
}

}  // namespace
}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace mote::render {

HWY_EXPORT(sampleCodes);

void sampleCodes(const SampleGrids& grids, SamplePlaces& places, SampleCodes& codes) {
    const std::size_t size = places.size;
    while (places.size % SamplePlaces::together != 0) places.add(glm::vec3(0.0F));
    HWY_DYNAMIC_DISPATCH(sampleCodes)(grids, places, codes);
    places.size = size;
}

}  // namespace mote::render
#endif
