// SPDX-License-Identifier: GPL-3.0-or-later
//
// OwnWalk: the way of a vector of a packet's pixels that have rays of their own, through one field and the
// points of one layer. What both let through is multiplied (SmoothWalk): so rays go through the field alone,
// from cell to cell in one go, and tell its light at each pixel's points, where they begin and end in a slab
// and midway; the points are added afterwards. Compiled once for each target (Highway's foreach_target),
// hence without #pragma once.
#if defined(MOTE_OWN_WALK_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_OWN_WALK_INL_H
#undef MOTE_OWN_WALK_INL_H
#else
#define MOTE_OWN_WALK_INL_H
#endif

#include <algorithm>
#include <array>
#include <limits>

#include "server/render/cpu/composite/own_points.h"
#include "server/render/cpu/composite/packet_walk-inl.h"
#include "server/render/cpu/composite/smooth_walk-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

class OwnWalk {
  public:
    /// `lane`: of the packet's pixels, the vector's first.
    OwnWalk(const CompositeFrame& frame, const Packet& packet, std::size_t lane, PacketSights& sights,
            OwnPoints& room)
        : frame_(frame), packet_(packet), lane_(lane), sights_(sights), room_(room) {}

    /// Whether a packet, which has entered the frame's only section, may be walked so. It must not depend on
    /// how wide vectors are.
    static bool suits(const CompositeFrame& frame, const Packet& packet) {
        return frame.cellByCell && packet.points.size() == 1 && packet.dots == nullptr &&
               packet.hitFields().size() == 1 && !frame.fields[packet.hitFields()[0]].grid &&
               faint(frame, packet);
    }

    /// False if it would be wrong: so much of the field lies among points that it matters how, or its colours
    /// change too much.
    HWY_NOINLINE bool run() {
        collect();
        ToldBorders told(room_.borders.data(), room_.mostLeft.data(), room_.told.data());
        PacketWalk walk(frame_, packet_, lane_, sights_);
        walk.run(frame_.sections[0], told, frame_.slabs);
        return addUp(walk.light());
    }
    const Light& light() const { return light_; }

  private:
    /// Whether the packet's nearest points let much through, each by itself.
    static bool faint(const CompositeFrame& frame, const Packet& packet) {
        constexpr float most = 1.0F;
        const FramePointLook& look = frame.points[0];
        const std::uint32_t slab = packet.nextPoints(0);
        if (!look.byDepth || slab >= frame.slabs) return look.tau <= most;
        const float depth = frame.depths[slab].nearest;
        return look.tau <= most * depth * depth;
    }

    static constexpr std::size_t rays = ToldBorders::rays;
    static constexpr float mostWrong = 0.008F;  ///< of linear light

    /// Brings together where the points of each pixel are, slab by slab, as long as they let light through.
    HWY_NOINLINE void collect() {
        const Floats d;
        V mostLeft = hn::Set(d, Light::least);  // behind what was brought together
        std::uint64_t open = ~std::uint64_t{0} >> (64 - rays);
        std::uint32_t slab = packet_.nextPoints(0);
        for (; slab < frame_.slabs && open != 0; slab = packet_.nextPoints(slab + 1)) {
            V weight, moment;
            hn::LoadInterleaved2(d, &packet_.cells(0, slab)[lane_].weight, weight, moment);
            const std::uint64_t held = bitsOf(hn::Gt(weight, hn::Zero(d))) & open;
            if (held == 0) continue;
            collect(slab, weight, moment, held, mostLeft);
            open &= ~bitsOf(hn::Gt(mostLeft, hn::Set(d, 1.0F)));
        }
        Lanes left;
        hn::Store(mostLeft, d, left.data());
        room_.makeRoom(rows_, rows_ + 1, rays);
        for (std::size_t i = 0; i < rays; ++i) {
            const std::size_t last = static_cast<std::size_t>(count_[i]) * rays + i;
            room_.borders[last] = std::numeric_limits<float>::max();
            room_.mostLeft[last] = left[i];
            most_ = std::max(most_, static_cast<std::size_t>(count_[i]));
        }
    }
    HWY_INLINE static std::uint64_t bitsOf(hn::Mask<Floats> mask) {
        std::uint64_t bits = 0;
        hn::StoreMaskBits(Floats(), mask, reinterpret_cast<std::uint8_t*>(&bits));
        return bits;
    }
    /// Those of some pixels in a slab: of one in one place a row, else three. Whatever stands in rows that a
    /// pixel does not have is written anew or never asked for; its optical depth is 0.
    HWY_INLINE void collect(std::uint32_t slab, V weight, V moment, std::uint64_t held, V& mostLeft) {
        const Floats d;
        const Ints ints;
        const SlabDepth& depth = frame_.depths[slab];
        const SpreadPoints spread(weight, moment, frame_.points[0], hn::Set(d, depth.nearest),
                                  hn::Set(d, depth.thickness));
        const V start = hn::Set(d, static_cast<float>(slab)), half = hn::Set(d, 0.5F);
        const V from = hn::Add(start, spread.near), to = hn::Add(start, spread.far);
        const auto single = hn::Le(to, from);
        Lanes begin, middle, end, left, one, ofHalf;
        alignas(64) std::array<std::int32_t, rays> more;
        hn::Store(from, d, begin.data());
        // In halves: what the field is around their middle matters.
        hn::Store(hn::Mul(half, hn::Add(from, to)), d, middle.data());
        hn::Store(to, d, end.data());
        hn::Store(mostLeft, d, left.data());
        hn::Store(hn::IfThenElseZero(single, hn::Neg(spread.tau)), d, one.data());
        hn::Store(hn::IfThenZeroElse(single, hn::Mul(half, spread.tau)), d, ofHalf.data());
        hn::Store(hn::IfThenElse(hn::RebindMask(ints, single), hn::Set(ints, 1), hn::Set(ints, 3)), ints,
                  more.data());
        room_.makeRoom(rows_, rows_ + 3, rays);
        rows_ += 3;
        for (; held != 0; held &= held - 1) {
            const std::size_t i = hwy::Num0BitsBelowLS1Bit_Nonzero64(held);
            bring(static_cast<std::size_t>(count_[i]) * rays + i, {begin[i], middle[i], end[i]}, left[i],
                  {one[i], ofHalf[i], ofHalf[i]});
            count_[i] += more[i];
        }
        mostLeft = hn::Div(mostLeft, hn::Max(expMinus(spread.tau), hn::Set(d, 1e-6F)));
    }
    HWY_INLINE void bring(std::size_t first, const std::array<float, 3>& borders, float mostLeft,
                          const std::array<float, 3>& tau) {
        for (std::size_t k = 0; k < 3; ++k) {
            room_.borders[first + k * rays] = borders[k];
            room_.mostLeft[first + k * rays] = mostLeft;
            room_.tau[first + k * rays] = tau[k];
        }
    }

    /// `end`: what the field alone is.
    HWY_NOINLINE bool addUp(const Light& end) {
        const Floats d;
        const auto color = [&](std::size_t c)
                               HWY_ATTR { return hn::LoadU(d, packet_.pointColors[0][c].data() + lane_); };
        const std::array<V, 3> colors{color(0), color(1), color(2)};
        const hn::Vec<Ints> counts = hn::Load(Ints(), count_.data());
        Light passed;  // of the field alone, up to the border before
        V through = hn::Set(d, 1.0F), throughBefore = through, lostBefore = hn::Zero(d);
        auto right = hn::Gt(through, hn::Zero(d)), halfBefore = hn::Lt(through, hn::Zero(d));
        for (std::size_t k = 0; k < most_; ++k) {
            const auto more = hn::Gt(counts, hn::Set(Ints(), static_cast<std::int32_t>(k)));
            const Light here = told(k, hn::RebindMask(d, more), passed);
            const V tau = hn::LoadU(d, &room_.tau[k * rays]);
            const Light from = chosen(hn::Gt(tau, hn::Zero(d)), passed, here);
            addFields(through, passed, from);
            const V depth = hn::Abs(tau);
            Light mixed;
            V let;
            gatherMixed(depth, colors, from, here, let, mixed);
            // Taken as even, as much as an eighth of what is lost may be wrong of that share of faint points;
            // behind the first of strong ones it matters where it was lost, if not as much of it in one half
            // of them as in the other.
            const V lost = hn::Sub(from.left, here.left);
            const V error = hn::Mul(hn::Mul(through, hn::Min(depth, hn::Set(d, 1.0F))), hn::Mul(lost, lost));
            const auto even = hn::Le(error, hn::Mul(from.left, hn::Set(d, 8.0F * mostWrong)));
            const auto half = hn::Gt(tau, hn::Zero(d)), second = hn::And(half, halfBefore);
            const V uneven = hn::IfThenElseZero(second, hn::Abs(hn::Sub(lost, lostBefore)));
            const auto faint = hn::Or(hn::Le(depth, hn::Set(d, 0.7F)),
                                      hn::Le(hn::Mul(throughBefore, uneven), hn::Set(d, 2.0F * mostWrong)));
            right = hn::And(right, hn::And(faint, even));  // neither of what is no number
            halfBefore = half, lostBefore = lost, throughBefore = through;
            light_.red = hn::MulAdd(through, mixed.red, light_.red);
            light_.green = hn::MulAdd(through, mixed.green, light_.green);
            light_.blue = hn::MulAdd(through, mixed.blue, light_.blue);
            through = hn::Mul(through, let);
            passed = here;
        }
        const auto ended = hn::Lt(hn::Mul(through, passed.left), hn::Set(d, Light::least));
        addFields(hn::IfThenZeroElse(ended, through), passed, end);
        light_.left = hn::Mul(through, end.left);
        light_.gone();
        return hn::AllTrue(d, right);
    }
    HWY_INLINE Light told(std::size_t row, hn::Mask<Floats> met, const Light& otherwise) const {
        const Floats d;
        Light at;
        hn::LoadInterleaved4(d, room_.told[row * rays].data(), at.left, at.red, at.green, at.blue);
        return chosen(met, at, otherwise);
    }
    HWY_INLINE static Light chosen(hn::Mask<Floats> which, const Light& one, const Light& other) {
        Light light;
        light.left = hn::IfThenElse(which, one.left, other.left);
        light.red = hn::IfThenElse(which, one.red, other.red);
        light.green = hn::IfThenElse(which, one.green, other.green);
        light.blue = hn::IfThenElse(which, one.blue, other.blue);
        return light;
    }
    /// The light of the field between two places, behind points that let so much through.
    HWY_INLINE void addFields(V through, const Light& from, const Light& to) {
        light_.red = hn::MulAdd(through, hn::Sub(to.red, from.red), light_.red);
        light_.green = hn::MulAdd(through, hn::Sub(to.green, from.green), light_.green);
        light_.blue = hn::MulAdd(through, hn::Sub(to.blue, from.blue), light_.blue);
    }

    alignas(64) std::array<std::int32_t, rays> count_{};  // borders of each pixel
    Light light_;
    const CompositeFrame& frame_;
    const Packet& packet_;
    const std::size_t lane_;
    PacketSights& sights_;
    OwnPoints& room_;
    std::size_t rows_ = 0;  // that there is room for
    std::size_t most_ = 0;  // borders of a pixel
};

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
