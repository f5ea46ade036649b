// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which pixels hold so many points that more are not seen: leaves all of whose pixels do are not read. For
// the files that are compiled for each instruction set.
#if defined(MOTE_FULL_PIXELS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_FULL_PIXELS_INL_H
#undef MOTE_FULL_PIXELS_INL_H
#else
#define MOTE_FULL_PIXELS_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "server/render/cpu/point_places-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace {

/// Tells where more points would not be seen.
class FullPixels {
  public:
    HWY_INLINE FullPixels(const PointMap& map, FullCount full, const std::uint32_t* counts)
        : width_(map.width), full_(full), counts_(counts) {}

    HWY_INLINE bool four(std::int32_t first) const {
        if (full_ == neverFull) return false;
        const std::uint32_t* const above = counts_ + first;
        const std::uint32_t* const below = above + width_;
        return std::min(std::min(above[0], above[1]), std::min(below[0], below[1])) >= full_;
    }

    /// Whether a leaf lies in the picture and all pixels that are no further from it than so many are full. A
    /// disc touches none whose nearer edge is further than its reach less half a pixel.
    HWY_INLINE bool around(const PointMap& map, const LeafPlaces& places, std::size_t i, float reach) const {
        // Points are rounded, by no more than this.
        constexpr float margin = 1.0F / 64.0F;
        if (full_ == neverFull) return false;
        const float far = reach + margin;
        const float width = static_cast<float>(map.width), height = static_cast<float>(map.height);
        if (!(places.left[i] >= margin && places.right[i] <= width - margin && places.top[i] >= margin &&
              places.bottom[i] <= height - margin))
            return false;
        const auto left = static_cast<std::size_t>(std::max(places.left[i] - far, 0.0F));
        const auto top = static_cast<std::size_t>(std::max(places.top[i] - far, 0.0F));
        const auto right = static_cast<std::size_t>(std::min(places.right[i] + far, width - 1.0F)) + 1;
        const auto bottom = static_cast<std::size_t>(std::min(places.bottom[i] + far, height - 1.0F)) + 1;
        return (right - left) * (bottom - top) <= mostLooked && all(left, top, right, bottom);
    }

  private:
    /// Pixels; more would take longer than points do.
    static constexpr std::size_t mostLooked = 256;

    HWY_INLINE bool all(std::size_t left, std::size_t top, std::size_t right, std::size_t bottom) const {
        const hn::RebindToUnsigned<Ints> unsignedInts;
        for (std::size_t row = top; row < bottom; ++row) {
            for (std::size_t column = left; column < right; column += mostLanes) {
                const auto held = hn::LoadU(unsignedInts, counts_ + row * width_ + column);
                const auto others = hn::Not(hn::FirstN(unsignedInts, right - column));
                const auto isFull = hn::Eq(hn::Max(held, hn::Set(unsignedInts, full_)), held);
                if (!hn::AllTrue(unsignedInts, hn::Or(isFull, others))) return false;
            }
        }
        return true;
    }

    const std::size_t width_;
    const FullCount full_;
    const std::uint32_t* const counts_;
};

}  // namespace
}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
