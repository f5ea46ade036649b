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

#include <limits>
#include <numeric>

#include "server/render/cpu/composite/field_march-inl.h"
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
    /// Each ray has borders of its own: border k of ray i is borders[k * rays + i], its row likewise, and so
    /// is what may be left before it if nothing more is seen.
    HWY_INLINE ToldBorders(const float* borders, const float* mostLeft, TileLattice::Told* rows)
        : borders_(borders), mostLeft_(mostLeft), step_(rays) {
        rows_.fill(rows);
        std::iota(next_.begin(), next_.end(), 0);
    }

    /// The slab of the next border, where it is the same of all rays.
    float next() const { return borders_[next_[0]]; }
    const float* borders() const { return borders_; }
    /// Null: Light::least.
    const float* mostLeft() const { return mostLeft_; }
    const std::int32_t* nextOfEach() const { return next_.data(); }
    /// From one border of a ray to its next.
    std::int32_t step() const { return step_; }

    /// Tells the light at each border up to a slab of each ray, before which it does not change. (No vector
    /// is handed over: a function that takes one leaves its upper half in use, which slows what follows.)
    HWY_NOINLINE void tellTo(const Lanes& until, const Light& light) {
        const Vectors vectors(light);
        for (std::size_t i = 0; i < rays; ++i) {
            for (; borders_[next_[i]] <= until[i]; next_[i] += step_) rows_[i][next_[i]] = vectors.told[i];
        }
    }
    HWY_INLINE void tellTo(float slab, const Light& light) {
        Lanes until;
        until.values.fill(slab);
        tellTo(until, light);
    }
    /// Tells that at the next border of each ray, and that some go on to the one behind it, as `next` has it:
    /// what is told of the others is told anew. No ray is asked for, as no processor foresees which it is.
    HWY_INLINE void tell(const Light& light, IntV next) {
        const Vectors vectors(light);
        for (std::size_t i = 0; i < rays; ++i) rows_[i][next_[i]] = vectors.told[i];
        hn::Store(next, Ints(), next_.data());
    }

  private:
    struct Vectors {
        alignas(64) std::array<TileLattice::Told, rays> told;

        HWY_INLINE explicit Vectors(const Light& light) {
            hn::StoreInterleaved4(light.left, light.red, light.green, light.blue, Floats(), told[0].data());
        }
    };

    alignas(64) std::array<std::int32_t, rays> next_{};
    const float* borders_;
    const float* mostLeft_ = nullptr;
    Rows rows_;
    std::int32_t step_ = 1;
};

/// The borders between two slabs, for a march that goes from cell to cell (marchCells): the light at those
/// that lie in a part follows from that at its ends.
class BorderLights {
  public:
    HWY_INLINE BorderLights(ToldBorders& told, const RayLanes& lanes, float from, float to,
                            const Light& light)
        : told_(&told),
          rate_(lanes.rate),
          start_(lanes.start),
          to_(hn::Set(Floats(), to)),
          mostLeft_(hn::Set(Floats(), Light::least)) {
        // Before a ray enters nothing changes.
        Lanes until;
        hn::Store(hn::Min(hn::Max(lanes.enter, hn::Set(Floats(), from)), to_), Floats(), until.data());
        told.tellTo(until, light);
        ahead_ = hn::Load(Ints(), told.nextOfEach());
        aim();
        aimLeft();
    }

    /// What is left of rays whose light does not change evenly in the part is told as no number (NaN). Of
    /// those that ended before it nothing changes any more: their borders are told at the end.
    HWY_INLINE void pass(const PassedPart& part, const SteepRays& rays) {
        const Floats d;
        const auto seen = hn::Gt(part.before.left, hn::Zero(d));
        const auto here = [&]() HWY_ATTR { return hn::And(seen, hn::Le(border_, part.back.way)); };
        auto which = here();
        if (hn::AllFalse(d, which)) return;
        // Of a part that hides less, little is wrong whatever its colours. At borders of a ray's own points
        // what is left follows from a parabola nearly enough, however steep.
        const auto steep = told_->mostLeft() != nullptr ? rays.colorful : rays.all;
        const auto wrong = hn::And(steep, hn::Gt(part.depth, hn::Set(d, PartLight::deep)));
        const PartLight within(part);
        for (; !hn::AllFalse(d, which); which = here()) {
            Light at = within.at(border_, which);
            at.left = hn::IfThenElse(wrong, hn::Set(d, std::numeric_limits<float>::quiet_NaN()), at.left);
            tell(which, at);
        }
        aimLeft();
    }
    /// The same of a part that changes nothing.
    HWY_INLINE void pass(V to, const Light& light) {
        const auto here = [&]() HWY_ATTR { return hn::And(light.seen(), hn::Le(border_, to)); };
        auto which = here();
        if (hn::AllFalse(Floats(), which)) return;
        for (; !hn::AllFalse(Floats(), which); which = here()) tell(which, light);
        aimLeft();
    }
    /// What may be left of each ray if nothing more is seen.
    HWY_INLINE V mostLeft() const { return mostLeft_; }

  private:
    HWY_INLINE void tell(hn::Mask<Floats> here, const Light& light) {
        const auto ints = hn::RebindMask(Ints(), here);
        ahead_ = hn::IfThenElse(ints, hn::Add(ahead_, hn::Set(Ints(), told_->step())), ahead_);
        told_->tell(light, ahead_);
        aim();
    }
    HWY_INLINE V wayOf(V slab) const {
        const Floats d;
        return hn::Min(hn::Max(hn::MulAdd(slab, rate_, start_), hn::Zero(d)), hn::Set(d, 1.0F));
    }
    HWY_INLINE V ofNext(const float* numbers) const {
        const auto* const bytes = reinterpret_cast<const std::uint8_t*>(numbers);
        return hn::BitCast(Floats(), gatherWord(bytes, hn::ShiftLeft<2>(ahead_)));
    }
    HWY_INLINE void aim() {
        const V slab = ofNext(told_->borders());
        // A border at the end is told when all have come there.
        border_ = hn::IfThenElse(hn::Lt(slab, to_), wayOf(slab), hn::Set(Floats(), 2.0F));
    }
    HWY_INLINE void aimLeft() {
        if (told_->mostLeft() != nullptr) mostLeft_ = ofNext(told_->mostLeft());
    }

    ToldBorders* told_;
    V rate_, start_, to_, mostLeft_;
    IntV ahead_;  // the number of each ray's next border
    V border_;    // its way
};

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
