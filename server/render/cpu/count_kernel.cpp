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

#include "server/render/cpu/full_pixels-inl.h"
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
    HWY_INLINE LeafCount(const PointMap& map, const LeafRun& run, FullCount full, std::uint32_t* counts)
        : map_(map),
          run_(run),
          counts_(counts),
          full_(map, full, counts),
          pixels_(map, counts),
          inView_(map, counts) {}

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
                if (!full_.four(ways_.first[i])) countInFour(i, points, count);
                break;
            case inside:
                if (!full_.around(map_, places_, i, 0.0F)) countInside(cell, i, points, count);
                break;
            default:
                countAtBorder(cell, i, points, count);
        }
    }

    HWY_INLINE void countInFour(std::size_t i, const PackedPosition* points, std::size_t count) {
        countQuarters(places_, i, points, count, run_.end).addTo(counts_ + ways_.first[i], map_.width);
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
    const FullPixels full_;
    const Pixels pixels_;
    const PixelsInView inView_;
    LeafPlaces places_;
    LeafWays ways_;
};

template <bool perspective>
std::uint64_t countLeaves(const PointMap& map, const LeafRun& run, FullCount full, std::uint32_t* counts) {
    return LeafCount<perspective>(map, run, full, counts).count();
}

std::uint64_t countPoints(const PointMap& map, const LeafRun& run, FullCount full, std::uint32_t* counts) {
    return map.perspective ? countLeaves<true>(map, run, full, counts)
                           : countLeaves<false>(map, run, full, counts);
}

/// Adds discs to the pixels of a picture, a vector of pixels at a time.
class FlatSpread {
  public:
    HWY_INLINE FlatSpread(const PointMap& map, const FlatDiscs& discs, std::uint32_t* counts)
        : box_(pictureOf(map)), discs_(discs), width_(map.width), counts_(counts) {}

    HWY_INLINE const PixelBox& box() const { return box_; }

    HWY_INLINE void add(const Discs& discs) const {
        for (std::size_t i = 0; i < discs.count(); ++i) {
            const PixelBox at = discs.box(i);
            const std::int32_t across = at.right - at.left;
            if (across <= 4) {
                addDisc<4>(discs, i, at);
                continue;
            }
            if constexpr (mostLanes > 8) {
                if (across <= 8) {
                    addDisc<8>(discs, i, at);
                    continue;
                }
            }
            addDisc<mostLanes>(discs, i, at);
        }
    }

  private:
    /// A vector is so many columns of the picture, and as many rows as it has room for.
    template <std::size_t columns>
    static constexpr LaneOffsets offsets = [] {
        LaneOffsets made{};
        for (std::size_t lane = 0; lane < mostLanes; ++lane) {
            const std::size_t row = lane / columns;
            made.x[lane] = static_cast<float>(lane % columns) + 0.5F;
            made.y[lane] = static_cast<float>(row) + 0.5F;
        }
        return made;
    }();

    template <std::size_t columns>
    HWY_INLINE void addDisc(const Discs& discs, std::size_t i, const PixelBox& at) const {
        constexpr auto rows = static_cast<std::int32_t>(mostLanes / columns);
        const hn::RebindToUnsigned<Ints> unsignedInts;
        const Float x = hn::Set(floats, discs.x(i)), y = hn::Set(floats, discs.y(i));
        const Float reach = hn::Set(floats, discs_.reach);
        const Float offsetX = hn::Load(floats, offsets<columns>.x.data());
        const Float offsetY = hn::Load(floats, offsets<columns>.y.data());
        for (std::int32_t column = at.left; column < at.right; column += columns) {
            const Float centre = hn::Add(hn::Set(floats, static_cast<float>(column)), offsetX);
            const Float dx = hn::Sub(centre, x);
            // Beyond the picture's border is the next row.
            const Mask within = hn::Lt(centre, hn::Set(floats, static_cast<float>(at.right)));
            for (std::int32_t row = at.top; row < at.bottom; row += rows) {
                const Float dy = hn::Sub(hn::Add(hn::Set(floats, static_cast<float>(row)), offsetY), y);
                const Int steps =
                    hn::IfThenElseZero(hn::RebindMask(ints, within), coverageSteps(dx, dy, reach));
                const auto units = hn::GatherIndex(unsignedInts, discs_.units.data(), steps);
                addRows<columns>(units,
                                 static_cast<std::size_t>(row) * width_ + static_cast<std::size_t>(column),
                                 std::min(rows, at.bottom - row));
            }
        }
    }

    template <std::size_t columns, class Units>
    HWY_INLINE void addRows(Units units, std::size_t first, std::int32_t rows) const {
        const hn::CappedTag<std::uint32_t, columns> tag;
        const hn::RebindToUnsigned<Ints> unsignedInts;
        HWY_ALIGN std::array<std::uint32_t, mostLanes> each;
        hn::Store(units, unsignedInts, each.data());
        for (std::int32_t row = 0; row < rows; ++row) {
            std::uint32_t* const to = counts_ + first + static_cast<std::size_t>(row) * width_;
            const auto held = hn::LoadU(tag, to);
            const auto added = hn::Load(tag, each.data() + static_cast<std::size_t>(row) * columns);
            hn::StoreU(hn::Add(held, hn::Min(added, hn::Not(held))), tag, to);
        }
    }

    const PixelBox box_;
    const FlatDiscs& discs_;
    const std::size_t width_;
    std::uint32_t* const counts_;
};

template <bool perspective>
std::uint64_t countDiscsOf(const PointMap& map, const LeafRun& run, const FlatDiscs& look, FullCount full,
                           std::uint32_t* counts) {
    const FlatSpread spread(map, look, counts);
    const FullPixels fullPixels(map, full, counts);
    const NearBox near(spread.box(), look.reach);
    const PackedPosition* points = run.points;
    std::uint64_t drawn = 0;
    LeafPlaces places;
    Discs discs;
    for (std::size_t begin = 0; begin < run.leaves; begin += LeafPlaces::block) {
        const std::size_t size = std::min(LeafPlaces::block, run.leaves - begin);
        placeLeaves<perspective, false>(map, run.cells + begin, size, places);
        for (std::size_t i = 0; i < size; points += run.count[begin + i], ++i) {
            const std::size_t count = run.drawn[begin + i];
            if (count == 0 || places.outside(map, i, look.reach)) continue;
            if (fullPixels.around(map, places, i, look.reach - 0.5F)) {
                drawn += count;
                continue;
            }
            const LeafMap<perspective> toScreen(map, run.cells[begin + i], places, i);
            for (std::size_t k = 0; k < count; k += hn::Lanes(floats)) {
                const Projected at = toScreen(loadPlaces(points + k, run.end));
                const Mask seen = near(at, hn::FirstN(floats, count - k));
                discs.set(at.x, at.y, seen, look.reach, spread.box());
                spread.add(discs);
                drawn += discs.count();
            }
        }
    }
    return drawn;
}

std::uint64_t countDiscs(const PointMap& map, const LeafRun& run, const FlatDiscs& discs, FullCount full,
                         std::uint32_t* counts) {
    return map.perspective ? countDiscsOf<true>(map, run, discs, full, counts)
                           : countDiscsOf<false>(map, run, discs, full, counts);
}

void countScreenDiscs(const PointMap& map, const ScreenPoint* points, std::size_t count,
                      const FlatDiscs& look, std::uint32_t* counts) {
    const FlatSpread spread(map, look, counts);
    Discs discs;
    for (std::size_t i = 0; i < count; i += mostLanes) {
        discs.set(points + i, std::min(count - i, mostLanes), look.reach, spread.box());
        spread.add(discs);
    }
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
HWY_EXPORT(countDiscs);
HWY_EXPORT(countScreenDiscs);
HWY_EXPORT(countPreview);

std::uint64_t countPoints(const PointMap& map, const LeafRun& run, FullCount full, std::uint32_t* counts) {
    return HWY_DYNAMIC_DISPATCH(countPoints)(map, run, full, counts);
}

std::uint64_t countDiscs(const PointMap& map, const LeafRun& run, const FlatDiscs& discs, FullCount full,
                         std::uint32_t* counts) {
    return HWY_DYNAMIC_DISPATCH(countDiscs)(map, run, discs, full, counts);
}

void countScreenDiscs(const PointMap& map, const ScreenPoint* points, std::size_t count,
                      const FlatDiscs& discs, std::uint32_t* counts) {
    HWY_DYNAMIC_DISPATCH(countScreenDiscs)(map, points, count, discs, counts);
}

std::uint64_t countPreview(const PointMap& map, const PreviewRun& run, std::uint32_t* counts) {
    return HWY_DYNAMIC_DISPATCH(countPreview)(map, run, counts);
}

}  // namespace mote::render
#endif
