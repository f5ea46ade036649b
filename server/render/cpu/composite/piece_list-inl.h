// SPDX-License-Identifier: GPL-3.0-or-later
//
// PieceList: the pieces of the ways of a vector of rays, as many as each ray wants, one ray's after the
// other's, so that a vector of pieces is full even if few rays want many. Compiled once for each target
// (Highway's foreach_target), hence without #pragma once.
#if defined(MOTE_PIECE_LIST_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_PIECE_LIST_INL_H
#undef MOTE_PIECE_LIST_INL_H
#else
#define MOTE_PIECE_LIST_INL_H
#endif

#include <array>
#include <cstring>

#include "server/render/cpu/composite/density_sample-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t laneCount = hn::MaxLanes(Floats());

/// Numbers of lanes, one for each lane.
using LaneChoice = decltype(hn::IndicesFromVec(Floats(), IntV()));

/// What is in the chosen lanes.
HWY_INLINE V of(V values, const LaneChoice& lanes) {
    return hn::TableLookupLanes(values, lanes);
}

/// The lanes of some numbers; of those beyond the last the last.
HWY_INLINE LaneChoice chosen(V numbers) {
    const Floats d;
    const V last = hn::Set(d, static_cast<float>(laneCount - 1));
    return hn::IndicesFromVec(d, truncated(d, hn::Min(numbers, last)));
}

/// Of each lane the one `back` before, around.
HWY_INLINE LaneChoice lanesBefore(std::size_t back) {
    const Ints ints;
    const auto ahead = static_cast<std::int32_t>(laneCount - back);
    const auto last = static_cast<std::int32_t>(laneCount - 1);
    return hn::IndicesFromVec(Floats(), hn::And(hn::Iota(ints, ahead), hn::Set(ints, last)));
}

/// Of each lane the sum of it and all before.
template <std::size_t back = 1>
HWY_INLINE V sumsTo(V values) {
    if constexpr (back >= laneCount) {
        return values;
    } else {
        const V moved = hn::IfThenZeroElse(hn::FirstN(Floats(), back), of(values, lanesBefore(back)));
        return sumsTo<2 * back>(hn::Add(values, moved));
    }
}

/// Into which pieces the ways of rays are cut: spans one after the other, each of which is cut evenly.
class PieceSpans {
  public:
    static constexpr std::size_t most = 3;
    static constexpr float mostPieces = 16.0F;  ///< of each

    HWY_INLINE PieceSpans() : count_(hn::Zero(Floats())) {}
    /// So many pieces, of each ray, from one place to another.
    HWY_INLINE void add(V from, V to, V pieces) {
        Span& span = spans_[size_++];
        span.step = hn::Div(hn::Sub(to, from), hn::Max(pieces, hn::Set(Floats(), 1.0F)));
        span.shift = hn::NegMulAdd(count_, span.step, from);
        count_ = hn::Add(count_, pieces);
        span.until = count_;
    }
    /// Of each ray, in all spans.
    V count() const { return count_; }
    /// Where a piece ends, by its number from 0 on, of the chosen rays.
    HWY_INLINE V endOf(V piece, const LaneChoice& rays) const {
        const V next = hn::Add(piece, hn::Set(Floats(), 1.0F));
        const auto endIn = [&](const Span& span) HWY_ATTR {
            return hn::MulAdd(next, of(span.step, rays), of(span.shift, rays));
        };
        V end = endIn(spans_[0]);
        for (std::size_t i = 1; i < size_; ++i)
            end = hn::IfThenElse(hn::Ge(piece, of(spans_[i - 1].until, rays)), endIn(spans_[i]), end);
        return end;
    }

  private:
    struct Span {
        V until;        // pieces up to its end
        V step, shift;  // piece i ends at (i + 1) * step + shift
    };
    std::array<Span, most> spans_;
    std::size_t size_ = 0;
    V count_;
};

class PieceList {
  public:
    /// `counts`: of each ray, PieceSpans::most * PieceSpans::mostPieces at most.
    HWY_INLINE explicit PieceList(V counts) : counts_(counts), ends_(sumsTo(counts)) {
        alignas(64) std::array<std::int32_t, laneCount> count;
        hn::Store(truncated(Floats(), counts), Ints(), count.data());
        for (std::size_t ray = 0; ray < laneCount; ++ray) {
            const auto all = static_cast<std::size_t>(count[ray]);
            std::size_t i = 0;
            do {  // Too many are overwritten by the next ray's.
                std::memset(rays_.data() + size_ + i, static_cast<int>(ray), stride);
                std::memcpy(numbers_.data() + size_ + i, ascending.data() + i, stride);
                i += stride;
            } while (i < all);
            size_ += all;
        }
        std::memset(rays_.data() + size_, 0, stride);
        std::memset(numbers_.data() + size_, 0, stride);
    }
    std::size_t size() const { return size_; }
    /// The rays of a vector of pieces, from one on; beyond the last piece the first ray.
    HWY_INLINE LaneChoice rays(std::size_t first) const {
        return hn::IndicesFromVec(Floats(), load(rays_.data() + first));
    }
    /// The numbers that these have among the pieces of their ray, from 0 on; beyond the last piece 0.
    HWY_INLINE V numbers(std::size_t first) const {
        return hn::ConvertTo(Floats(), load(numbers_.data() + first));
    }
    /// In which lanes of these each ray's lie: those from `begin` to before `end`, maybe none.
    struct Lanes {
        V begin, end;
    };
    HWY_INLINE Lanes lanesOf(std::size_t first) const {
        const Floats d;
        const V end = hn::Sub(ends_, hn::Set(d, static_cast<float>(first)));
        return {hn::Max(hn::Sub(end, counts_), hn::Zero(d)),
                hn::Min(end, hn::Set(d, static_cast<float>(laneCount)))};
    }

  private:
    static constexpr std::size_t stride = 16;
    static constexpr std::size_t mostOfRay =
        PieceSpans::most * static_cast<std::size_t>(PieceSpans::mostPieces);
    static constexpr auto ascending = [] {
        std::array<std::uint8_t, mostOfRay> numbers{};
        for (std::size_t i = 0; i < mostOfRay; ++i) numbers[i] = static_cast<std::uint8_t>(i);
        return numbers;
    }();
    static_assert(mostOfRay % stride == 0 && stride >= laneCount);

    HWY_INLINE static IntV load(const std::uint8_t* bytes) {
        return hn::PromoteTo(Ints(), hn::LoadU(hn::Rebind<std::uint8_t, Floats>(), bytes));
    }

    std::array<std::uint8_t, laneCount * mostOfRay + stride> rays_, numbers_;
    std::size_t size_ = 0;
    V counts_, ends_;
};

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
