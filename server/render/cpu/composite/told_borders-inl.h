// SPDX-License-Identifier: GPL-3.0-or-later
//
// The borders of slabs at which the light of a vector of rays is told to a TileLattice: rays go on from cell
// to cell there, each at a way of its own, and do not wait for each other. Compiled once for each target
// (Highway's foreach_target), hence without #pragma once.
#if defined(MOTE_TOLD_BORDERS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_TOLD_BORDERS_INL_H
#undef MOTE_TOLD_BORDERS_INL_H
#else
#define MOTE_TOLD_BORDERS_INL_H
#endif

#include "server/render/cpu/composite/light-inl.h"
#include "server/render/cpu/composite/tile_lattice.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

class ToldBorders {
  public:
    static constexpr std::size_t rays = hn::MaxLanes(Floats());
    using Rows = std::array<TileLattice::Told*, rays>;

    /// `borders`: slabs, ascending, and one beyond all. `rows`: of each ray, a row for each of the borders.
    HWY_INLINE ToldBorders(const float* borders, const Rows& rows) : borders_(borders), rows_(rows) {}

    /// The slab of the next border, where it is the same of all rays.
    float next() const { return borders_[next_[0]]; }
    const float* borders() const { return borders_; }
    const std::int32_t* nextOfEach() const { return next_.data(); }

    /// Tells the light at each border up to a slab of each ray, before which it does not change. (No vector
    /// is handed over: a function that takes one leaves its upper half in use, which slows what follows.)
    HWY_NOINLINE void tellTo(const Lanes& until, const Light& light) {
        const Vectors vectors(light);
        for (std::size_t i = 0; i < rays; ++i) {
            while (borders_[next_[i]] <= until[i]) rows_[i][next_[i]++] = vectors.told[i];
        }
    }
    HWY_INLINE void tellTo(float slab, const Light& light) {
        Lanes until;
        until.values.fill(slab);
        tellTo(until, light);
    }
    /// Tells that of some rays at the next border of each; `which`: a bit each.
    HWY_INLINE void tell(std::uint64_t which, const Light& light) {
        const Vectors vectors(light);
        for (; which != 0; which &= which - 1) {
            const std::size_t i = hwy::Num0BitsBelowLS1Bit_Nonzero64(which);
            rows_[i][next_[i]++] = vectors.told[i];
        }
    }

  private:
    struct Vectors {
        alignas(64) std::array<TileLattice::Told, rays> told;

        HWY_INLINE explicit Vectors(const Light& light) {
            hn::StoreInterleaved4(light.left, light.red, light.green, light.blue, Floats(), told[0].data());
        }
    };

    const float* borders_;
    Rows rows_;
    alignas(64) std::array<std::int32_t, rays> next_{};
};

/// The borders between two slabs as stops of a march (marchCells).
class BorderStops {
  public:
    HWY_INLINE BorderStops(ToldBorders& told, const RayLanes& lanes, float from, float to, const Light& light)
        : told_(told),
          enter_(lanes.enter),
          rate_(lanes.rate),
          start_(lanes.start),
          to_(hn::Set(Floats(), to)) {
        // Before a ray enters nothing changes.
        Lanes until;
        hn::Store(hn::Min(hn::Max(enter_, hn::Set(Floats(), from)), to_), Floats(), until.data());
        told.tellTo(until, light);
        ahead_ = hn::Load(Ints(), told.nextOfEach());
        end_ = wayOf(to_);
        aim();
    }

    HWY_INLINE V next() const { return next_; }
    HWY_INLINE hn::Mask<Floats> reached(V way) {
        const auto here = hn::Ge(way, border_);
        if (!hn::AllFalse(Floats(), here)) {
            ahead_ =
                hn::IfThenElse(hn::RebindMask(Ints(), here), hn::Add(ahead_, hn::Set(Ints(), 1)), ahead_);
            aim();
        }
        return here;
    }
    HWY_INLINE void stop(hn::Mask<Floats> here, const Light& light) {
        std::uint64_t which = 0;
        hn::StoreMaskBits(Floats(), here, reinterpret_cast<std::uint8_t*>(&which));
        if (which != 0) told_.tell(which, light);
    }

  private:
    HWY_INLINE V wayOf(V slab) const {
        const Floats d;
        return hn::Min(hn::Max(hn::MulAdd(slab, rate_, start_), hn::Zero(d)), hn::Set(d, 1.0F));
    }
    HWY_INLINE void aim() {
        const Floats d;
        const auto* const borders = reinterpret_cast<const std::uint8_t*>(told_.borders());
        const V slab = hn::BitCast(d, gatherWord(borders, hn::ShiftLeft<2>(ahead_)));
        // A border at the end is told when all have come there.
        border_ = hn::IfThenElse(hn::Lt(slab, to_), wayOf(slab), hn::Set(d, 2.0F));
        next_ = hn::Min(border_, end_);
    }

    ToldBorders& told_;
    V enter_, rate_, start_, to_, end_;
    IntV ahead_;       // the number of each ray's next border
    V border_, next_;  // its way; that or the end's
};

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
