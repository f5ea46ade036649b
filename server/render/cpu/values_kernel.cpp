// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/values_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/render/cpu/values_kernel.cpp"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "server/render/cpu/full_pixels-inl.h"
#include "server/render/cpu/leaf_ways-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace {

constexpr ValueSum one = ValueSum{1} << countShift;

HWY_INLINE ValueSum sumOf(ValueCode code) {
    return code == noValue ? 0 : one + code;
}

/// Points fall into the very pixels in which count_kernel.cpp counts them. `nearest`: sums are keys.
/// `counted`: points are counted as well.
template <bool perspective, bool nearest, bool counted = false>
class LeafValues {
  public:
    HWY_INLINE LeafValues(const PointMap& map, const LeafRun& run, ValueSum* sums, FullCount full = neverFull,
                          std::uint32_t* counts = nullptr)
        : map_(map),
          run_(run),
          sums_(sums),
          counts_(counts),
          full_(map, full, counts),
          nowhere_(hn::Iota(ints, static_cast<std::int32_t>(map.width * map.height))) {
        for (const auto& side : map.edge) {
            toFront_ += std::min(side[PointMap::rowSlab], 0.0);
            depth_ += std::abs(side[PointMap::rowSlab]);
        }
    }

    /// Returns how many points are counted.
    HWY_INLINE std::uint64_t add(const ValueCode* codes) {
        const PackedPosition* points = run_.points;
        std::uint64_t drawn = 0;
        for (std::size_t begin = 0; begin < run_.leaves; begin += LeafPlaces::block) {
            const std::size_t size = std::min(LeafPlaces::block, run_.leaves - begin);
            placeLeaves<perspective, nearest>(map_, run_.cells + begin, size, places_);
            ways_.choose(map_, places_, size);
            for (std::size_t i = 0; i < size; ++i) {
                const std::size_t count = run_.drawn[begin + i];
                if (count > 0 && ways_.way[i] != notAtAll) {
                    if constexpr (counted) drawn += count;
                    if (!isHidden(i)) {
                        addLeaf(run_.cells[begin + i], i, points, codes, count);
                    } else if (counted && !isFull(i)) {
                        countHidden(run_.cells[begin + i], i, points, count);
                    }
                }
                points += run_.count[begin + i];
                codes += run_.count[begin + i];
            }
        }
        return drawn;
    }

  private:
    HWY_INLINE void addLeaf(LeafCell cell, std::size_t i, const PackedPosition* points,
                            const ValueCode* codes, std::size_t count) {
        if (ways_.way[i] == inOnePixel) {
            addInOnePixel(cell, i, points, codes, count);
        } else if (ways_.way[i] == atBorder) {
            addAtBorder(cell, i, points, codes, count);
        } else {
            addInside(cell, i, points, codes, count);
        }
    }

    /// Whether more points are not seen in the pixels of a leaf.
    HWY_INLINE bool isFull(std::size_t i) const {
        if (ways_.way[i] == inOnePixel || ways_.way[i] == atBorder) return false;
        if (ways_.way[i] == inFourPixels) return full_.four(ways_.first[i]);
        return full_.around(map_, places_, i, 0.0F);
    }

    /// Counts a leaf of which no point is nearer than what its pixels have.
    HWY_INLINE void countHidden(LeafCell cell, std::size_t i, const PackedPosition* points,
                                std::size_t count) {
        if (ways_.way[i] == inOnePixel) {
            counts_[ways_.first[i]] += static_cast<std::uint32_t>(count);
        } else if (ways_.way[i] == inFourPixels) {
            countQuarters(places_, i, points, count, run_.end).addTo(counts_ + ways_.first[i], map_.width);
        } else {
            const InsidePixels pixels(*this, cell, i);
            for (std::size_t k = 0; k < count; k += hn::Lanes(floats))
                countAt(pixels(loadPlaces(points + k, run_.end)), count - k);
        }
    }

    HWY_INLINE void countAt(Int pixels, std::size_t count) const {
        HWY_ALIGN std::array<std::uint32_t, mostLanes> places;
        storeSafely(pixels, places);
        const std::size_t lanes = std::min(count, hn::Lanes(ints));
        for (std::size_t k = 0; k < lanes; ++k) ++counts_[places[k]];
    }

    /// Whether all of a leaf is behind what its pixels have: of few pixels, as looking takes time.
    HWY_INLINE bool isHidden(std::size_t i) const {
        if constexpr (!nearest) return false;
        if (ways_.way[i] == atBorder) return false;
        // Points of the leaf are rounded, by no more than this.
        constexpr double ofEdge = 1e-3, ofDepth = 1e-6;
        const double origin = static_cast<double>(places_.origin[PointMap::rowSlab][i]);
        const double front = origin + static_cast<double>(places_.edge[i]) * (toFront_ - ofEdge * depth_) -
                             ofDepth * std::abs(origin);
        return front > static_cast<double>(depthOfKey(greatestKey(i)));
    }

    /// Of the pixels that a leaf may meet; none where these are many.
    HWY_INLINE NearKey greatestKey(std::size_t i) const {
        if (ways_.way[i] == inOnePixel) return sums_[ways_.first[i]];
        if (ways_.way[i] == inFourPixels) return lastKey(i);
        constexpr std::size_t many = 36;
        const auto pixels = [](float low, float high) {
            return static_cast<std::size_t>(high) - static_cast<std::size_t>(low) + 1;
        };
        const std::size_t columns = pixels(places_.left[i], places_.right[i]);
        const std::size_t rows = pixels(places_.top[i], places_.bottom[i]);
        if (columns * rows > many) return noKey;
        NearKey greatest = 0;
        for (std::size_t row = 0; row < rows; ++row) {
            const NearKey* const keys = sums_ + ways_.first[i] + row * map_.width;
            greatest = std::max(greatest, *std::max_element(keys, keys + columns));
        }
        return greatest;
    }

    HWY_INLINE void addInOnePixel(LeafCell cell, std::size_t i, const PackedPosition* points,
                                  const ValueCode* codes, std::size_t count) {
        ValueSum& sum = sums_[ways_.first[i]];
        if constexpr (counted) counts_[ways_.first[i]] += static_cast<std::uint32_t>(count);
        if constexpr (nearest) {
            const LinearRow toSlab = linearRow(map_, cell, places_, i, PointMap::rowSlab);
            for (std::size_t k = 0; k < count; k += hn::Lanes(floats)) {
                const Float depth = toSlab(loadPlaces(points + k, run_.end));
                if (isBehind(depth, sum)) continue;
                HWY_ALIGN std::array<float, mostLanes> depths;
                hn::Store(depth, floats, depths.data());
                const std::size_t lanes = std::min(count - k, hn::Lanes(floats));
                for (std::size_t lane = 0; lane < lanes; ++lane) nearer(sum, depths[lane], codes[k + lane]);
            }
        } else {
            ValueSum added = 0;
            for (std::size_t k = 0; k < count; ++k) added += sumOf(codes[k]);
            sum += added;
        }
    }

    /// Most points are behind what their pixel has already: a packet of such is passed over at once.
    HWY_INLINE static bool isBehind(Float depth, NearKey key) {
        return hn::AllTrue(floats, hn::Gt(depth, hn::Set(floats, depthOfKey(key))));
    }

    HWY_INLINE static void nearer(NearKey& key, float depth, ValueCode code) {
        if (code != noValue) key = std::min(key, nearKey(depth, code));
    }

    /// The last of what the pixels of a leaf have; of one that meets more than four, nothing.
    HWY_INLINE NearKey lastKey(std::size_t i) const {
        if (ways_.way[i] != inFourPixels) return noKey;
        const NearKey* const above = sums_ + ways_.first[i];
        const NearKey* const below = above + map_.width;
        return std::max(std::max(above[0], above[1]), std::max(below[0], below[1]));
    }

    /// The pixels of the points of a leaf that lies in the picture.
    class InsidePixels {
      public:
        HWY_INLINE InsidePixels(const LeafValues& values, LeafCell cell, std::size_t i)
            : values_(values),
              across_(distanceRow(values.places_.across, i)),
              down_(distanceRow(values.places_.down, i)),
              w_(linearRow(values.map_, cell, values.places_, i, PointMap::rowW)) {
            const auto row = static_cast<std::int32_t>(values.places_.row[i]);
            const auto column = static_cast<std::int32_t>(values.places_.column[i]);
            first_ = hn::Set(ints, row * static_cast<std::int32_t>(values.map_.width) + column);
        }
        HWY_INLINE Int operator()(const Places& at) const {
            Float columns = across_(at), rows = down_(at);
            if constexpr (perspective) {
                const Float inverse = hn::Div(hn::Set(floats, 1.0F), w_(at));
                columns = hn::Mul(columns, inverse);
                rows = hn::Mul(rows, inverse);
            }
            return values_.pixelsFrom(first_, columns, rows);
        }

      private:
        const LeafValues& values_;
        const LinearRow across_, down_, w_;
        Int first_;
    };

    HWY_INLINE void addInside(LeafCell cell, std::size_t i, const PackedPosition* points,
                              const ValueCode* codes, std::size_t count) {
        const InsidePixels pixels(*this, cell, i);
        const bool countBehind = counted && !isFull(i);
        for (std::size_t k = 0; k < count; k += hn::Lanes(floats)) {
            const Places at = loadPlaces(points + k, run_.end);
            const Float depth = depthOf(at, cell, i);
            if constexpr (nearest) {
                if (isBehind(depth, lastKey(i))) {
                    if (countBehind) countAt(pixels(at), count - k);
                    continue;
                }
            }
            addTo(pixels(at), depth, codes + k, count - k);
        }
    }

    HWY_NOINLINE void addAtBorder(LeafCell cell, std::size_t i, const PackedPosition* points,
                                  const ValueCode* codes, std::size_t count) {
        const LeafMap<perspective> toScreen(map_, cell, places_, i);
        const Float zero = hn::Zero(floats), width = hn::Set(floats, static_cast<float>(map_.width));
        const Float height = hn::Set(floats, static_cast<float>(map_.height));
        for (std::size_t k = 0; k < count; k += hn::Lanes(floats)) {
            const Places places = loadPlaces(points + k, run_.end);
            const Projected at = toScreen(places);
            const Mask inX = hn::And(hn::Ge(at.x, zero), hn::Lt(at.x, width));
            const Mask inY = hn::And(hn::Ge(at.y, zero), hn::Lt(at.y, height));
            const Mask seen = hn::And(hn::And(inX, inY), at.seen);
            const Float x = hn::IfThenElseZero(seen, at.x), y = hn::IfThenElseZero(seen, at.y);
            const Int pixels = pixelsFrom(hn::Zero(ints), x, y);
            addTo(hn::IfThenElse(hn::RebindMask(ints, seen), pixels, nowhere_), depthOf(places, cell, i),
                  codes + k, count - k);
        }
    }

    HWY_INLINE Int pixelsFrom(Int first, Float columns, Float rows) const {
        const Int down =
            hn::Mul(truncated(floats, hn::Floor(rows)), hn::Set(ints, static_cast<std::int32_t>(map_.width)));
        return hn::Add(hn::Add(first, truncated(floats, hn::Floor(columns))), down);
    }

    /// Of no use, and not computed, where it does not matter.
    HWY_INLINE Float depthOf(const Places& at, LeafCell cell, std::size_t i) const {
        if constexpr (nearest) return linearRow(map_, cell, places_, i, PointMap::rowSlab)(at);
        return hn::Zero(floats);
    }

    HWY_INLINE void addTo(Int pixels, Float depth, const ValueCode* codes, std::size_t count) const {
        HWY_ALIGN std::array<std::uint32_t, mostLanes> places;
        storeSafely(pixels, places);
        const std::size_t lanes = std::min(count, hn::Lanes(ints));
        if constexpr (counted) {
            for (std::size_t k = 0; k < lanes; ++k) ++counts_[places[k]];
        }
        if constexpr (nearest) {
            HWY_ALIGN std::array<float, mostLanes> depths;
            hn::Store(depth, floats, depths.data());
            for (std::size_t k = 0; k < lanes; ++k) nearer(sums_[places[k]], depths[k], codes[k]);
        } else {
            for (std::size_t k = 0; k < lanes; ++k) sums_[places[k]] += sumOf(codes[k]);
        }
    }

    /// Whatever rounding did, nothing else is written to.
    HWY_INLINE void storeSafely(Int pixels, std::array<std::uint32_t, mostLanes>& places) const {
        const hn::RebindToUnsigned<Ints> unsignedInts;
        const auto safe = hn::Min(hn::BitCast(unsignedInts, pixels), hn::BitCast(unsignedInts, nowhere_));
        hn::Store(safe, unsignedInts, places.data());
    }

    const PointMap& map_;
    const LeafRun& run_;
    ValueSum* const sums_;
    std::uint32_t* const counts_;
    const FullPixels full_;
    const Int nowhere_;
    double toFront_ = 0.0, depth_ = 0.0;  // of the box: from its origin to its front, and in all, slabs
    LeafPlaces places_;
    LeafWays ways_;
};

void addValues(const PointMap& map, const LeafRun& run, const ValueCode* codes, ValueSum* sums) {
    if (map.perspective)
        LeafValues<true, false>(map, run, sums).add(codes);
    else
        LeafValues<false, false>(map, run, sums).add(codes);
}

template <bool perspective>
std::uint64_t addNearestOf(const PointMap& map, const LeafRun& run, const ValueCode* codes, NearKey* keys,
                           FullCount full, std::uint32_t* counts) {
    if (counts == nullptr) return LeafValues<perspective, true>(map, run, keys).add(codes);
    return LeafValues<perspective, true, true>(map, run, keys, full, counts).add(codes);
}

std::uint64_t addNearest(const PointMap& map, const LeafRun& run, const ValueCode* codes, NearKey* keys,
                         FullCount full, std::uint32_t* counts) {
    return map.perspective ? addNearestOf<true>(map, run, codes, keys, full, counts)
                           : addNearestOf<false>(map, run, codes, keys, full, counts);
}

template <bool perspective>
void projectEachOf(const PointMap& map, LeafCell cell, const PackedPosition* points, std::size_t count,
                   const PackedPosition* end, ScreenPoint* out) {
    constexpr float outside = -1e30F;
    LeafPlaces places;
    placeLeaves<perspective>(map, &cell, 1, places);
    const LeafMap<perspective> toScreen(map, cell, places, 0);
    const LinearRow toSlab = linearRow(map, cell, places, 0, PointMap::rowSlab);
    HWY_ALIGN std::array<float, mostLanes> x, y, slab;
    for (std::size_t k = 0; k < count; k += hn::Lanes(floats)) {
        const Places at = loadPlaces(points + k, end);
        const Projected seen = toScreen(at);
        hn::Store(hn::IfThenElse(seen.seen, seen.x, hn::Set(floats, outside)), floats, x.data());
        hn::Store(seen.y, floats, y.data());
        hn::Store(toSlab(at), floats, slab.data());
        const std::size_t lanes = std::min(count - k, hn::Lanes(floats));
        for (std::size_t i = 0; i < lanes; ++i) out[k + i] = {x[i], y[i], slab[i]};
    }
}

void projectEach(const PointMap& map, LeafCell cell, const PackedPosition* points, std::size_t count,
                 const PackedPosition* end, ScreenPoint* out) {
    if (map.perspective)
        projectEachOf<true>(map, cell, points, count, end, out);
    else
        projectEachOf<false>(map, cell, points, count, end, out);
}

}  // namespace
}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace mote::render {

HWY_EXPORT(addValues);
HWY_EXPORT(addNearest);
HWY_EXPORT(projectEach);

void addValues(const PointMap& map, const LeafRun& run, const ValueCode* codes, ValueSum* sums) {
    HWY_DYNAMIC_DISPATCH(addValues)(map, run, codes, sums);
}

std::uint64_t addNearest(const PointMap& map, const LeafRun& run, const ValueCode* codes, NearKey* keys,
                         FullCount full, std::uint32_t* counts) {
    return HWY_DYNAMIC_DISPATCH(addNearest)(map, run, codes, keys, full, counts);
}

void projectEach(const PointMap& map, LeafCell cell, const storage::PackedPosition* points, std::size_t count,
                 const storage::PackedPosition* end, ScreenPoint* out) {
    HWY_DYNAMIC_DISPATCH(projectEach)(map, cell, points, count, end, out);
}

}  // namespace mote::render
#endif
