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
    /// Tells that of some rays at the next border of each; `which`: a bit each.
    HWY_INLINE void tell(std::uint64_t which, const Light& light) {
        const Vectors vectors(light);
        for (; which != 0; which &= which - 1) {
            const std::size_t i = hwy::Num0BitsBelowLS1Bit_Nonzero64(which);
            rows_[i][next_[i]] = vectors.told[i];
            next_[i] += step_;
        }
    }

    /// Rays, a bit each, of which something is told wrongly.
    void refuse(std::uint64_t which) { refused_ |= which; }
    bool refused(std::size_t ray) const { return (refused_ >> ray & 1U) != 0; }

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
    std::uint64_t refused_ = 0;
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
          mostLeft_(hn::Set(Floats(), Light::least)),
          wrong_(hn::Lt(to_, hn::Zero(Floats()))) {
        // Before a ray enters nothing changes.
        Lanes until;
        hn::Store(hn::Min(hn::Max(lanes.enter, hn::Set(Floats(), from)), to_), Floats(), until.data());
        told.tellTo(until, light);
        ahead_ = hn::Load(Ints(), told.nextOfEach());
        aim();
    }

    /// What is told of rays whose light does not change evenly in the part is not to be used. Of those that
    /// ended before it nothing changes any more: their borders are told at the end.
    HWY_INLINE void pass(const PassedPart& part, const Light& light, const SteepRays& rays) {
        const Floats d;
        const auto seen = hn::Gt(part.before.left, hn::Zero(d));
        auto here = hn::And(seen, hn::Le(border_, part.to));
        // Of a part that hides less, little is wrong whatever its colours. At borders of a ray's own points
        // what is left follows from a parabola nearly enough, however steep.
        const auto steep = told_->mostLeft() != nullptr ? rays.colorful : rays.all;
        const auto much = hn::And(steep, hn::Gt(part.depth, hn::Set(d, 0.25F)));
        wrong_ = hn::Or(wrong_, hn::And(here, much));
        for (; !hn::AllFalse(d, here); here = hn::And(seen, hn::Le(border_, part.to)))
            tell(here, lightAt(here, part, light));
    }
    /// The same of a part that changes nothing.
    HWY_INLINE void pass(V to, const Light& light) {
        const auto here = [&]() HWY_ATTR { return hn::And(light.seen(), hn::Le(border_, to)); };
        for (auto which = here(); !hn::AllFalse(Floats(), which); which = here()) tell(which, light);
    }
    /// What may be left of each ray if nothing more is seen.
    HWY_INLINE V mostLeft() const { return mostLeft_; }
    HWY_INLINE void end() {
        std::uint64_t which = 0;
        hn::StoreMaskBits(Floats(), wrong_, reinterpret_cast<std::uint8_t*>(&which));
        told_->refuse(which);
    }

  private:
    HWY_INLINE void tell(hn::Mask<Floats> here, const Light& light) {
        std::uint64_t which = 0;
        hn::StoreMaskBits(Floats(), here, reinterpret_cast<std::uint8_t*>(&which));
        told_->tell(which, light);
        const auto ints = hn::RebindMask(Ints(), here);
        ahead_ = hn::IfThenElse(ints, hn::Add(ahead_, hn::Set(Ints(), told_->step())), ahead_);
        aim();
    }
    HWY_INLINE Light lightAt(hn::Mask<Floats> here, const PassedPart& part, const Light& light) const {
        const V share = part.shareTo(border_, here);
        const auto between = [&](V before, V after)
                                 HWY_ATTR { return hn::MulAdd(share, hn::Sub(after, before), before); };
        Light at;
        at.left = between(part.before.left, light.left);
        at.red = between(part.before.red, light.red);
        at.green = between(part.before.green, light.green);
        at.blue = between(part.before.blue, light.blue);
        return at;
    }
    HWY_INLINE V wayOf(V slab) const {
        const Floats d;
        return hn::Min(hn::Max(hn::MulAdd(slab, rate_, start_), hn::Zero(d)), hn::Set(d, 1.0F));
    }
    HWY_INLINE void aim() {
        const Floats d;
        const IntV offset = hn::ShiftLeft<2>(ahead_);
        const auto of = [&](const float* numbers) HWY_ATTR {
            return hn::BitCast(d, gatherWord(reinterpret_cast<const std::uint8_t*>(numbers), offset));
        };
        const V slab = of(told_->borders());
        if (told_->mostLeft() != nullptr) mostLeft_ = of(told_->mostLeft());
        // A border at the end is told when all have come there.
        border_ = hn::IfThenElse(hn::Lt(slab, to_), wayOf(slab), hn::Set(d, 2.0F));
    }

    ToldBorders* told_;
    V rate_, start_, to_, mostLeft_;
    IntV ahead_;  // the number of each ray's next border
    V border_;    // its way
    hn::Mask<Floats> wrong_;
};

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
