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
        mostLeft_.values.fill(Light::least);
        std::uint64_t open = ~std::uint64_t{0} >> (64 - rays);
        std::uint32_t slab = packet_.nextPoints(0);
        for (; slab < frame_.slabs && open != 0; slab = packet_.nextPoints(slab + 1)) {
            V weight, moment;
            hn::LoadInterleaved2(d, &packet_.cells(0, slab)[lane_].weight, weight, moment);
            std::uint64_t held = 0;
            hn::StoreMaskBits(d, hn::Gt(weight, hn::Zero(d)), reinterpret_cast<std::uint8_t*>(&held));
            if ((held & open) != 0) open &= ~collect(slab, weight, moment, held & open);
        }
        room_.makeRoom(most_ + 1, rays);
        for (std::size_t i = 0; i < rays; ++i) {
            const std::size_t last = static_cast<std::size_t>(count_[i]) * rays + i;
            room_.borders[last] = std::numeric_limits<float>::max();
            room_.mostLeft[last] = mostLeft_[i];
        }
    }
    /// Those of some pixels in a slab. Returns the pixels behind whose points nothing is seen.
    HWY_INLINE std::uint64_t collect(std::uint32_t slab, V weight, V moment, std::uint64_t held) {
        const Floats d;
        const SlabDepth& depth = frame_.depths[slab];
        const SpreadPoints spread(weight, moment, frame_.points[0], hn::Set(d, depth.nearest),
                                  hn::Set(d, depth.thickness));
        const V start = hn::Set(d, static_cast<float>(slab));
        Lanes tau, from, to, hidden;
        hn::Store(spread.tau, d, tau.data());
        hn::Store(hn::Add(start, spread.near), d, from.data());
        hn::Store(hn::Add(start, spread.far), d, to.data());
        hn::Store(hn::Div(hn::Set(d, 1.0F), hn::Max(expMinus(spread.tau), hn::Set(d, 1e-6F))), d,
                  hidden.data());
        std::uint64_t ended = 0;
        for (; held != 0; held &= held - 1) {
            const std::size_t i = hwy::Num0BitsBelowLS1Bit_Nonzero64(held);
            bring(i, from[i], to[i], tau[i]);
            mostLeft_[i] *= hidden[i];
            if (mostLeft_[i] > 1.0F) ended |= std::uint64_t{1} << i;
        }
        return ended;
    }
    HWY_INLINE void bring(std::size_t pixel, float from, float to, float tau) {
        if (to <= from) return bring(pixel, from, -tau);
        bring(pixel, from, 0.0F);
        // In halves: what the field is around their middle matters.
        bring(pixel, 0.5F * (from + to), 0.5F * tau);
        bring(pixel, to, 0.5F * tau);
    }
    HWY_INLINE void bring(std::size_t pixel, float border, float tau) {
        const auto k = static_cast<std::size_t>(count_[pixel]++);
        if (k == most_) room_.makeRoom(++most_, rays);
        room_.borders[k * rays + pixel] = border;
        room_.mostLeft[k * rays + pixel] = mostLeft_[pixel];
        room_.tau[k * rays + pixel] = tau;
    }

    /// `end`: what the field alone is.
    HWY_NOINLINE bool addUp(const Light& end) {
        const Floats d;
        const auto color = [&](std::size_t c)
                               HWY_ATTR { return hn::LoadU(d, packet_.pointColors[0][c].data() + lane_); };
        const std::array<V, 3> colors{color(0), color(1), color(2)};
        const hn::Vec<Ints> counts = hn::Load(Ints(), count_.data());
        Light passed;  // of the field alone, up to the border before
        V through = hn::Set(d, 1.0F);
        auto right = hn::Gt(through, hn::Zero(d));
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
            // behind the first of strong ones it matters where it was lost.
            const V lost = hn::Sub(from.left, here.left);
            const V error = hn::Mul(hn::Mul(through, hn::Min(depth, hn::Set(d, 1.0F))), hn::Mul(lost, lost));
            const auto faint = hn::Or(hn::Le(depth, hn::Set(d, 0.7F)),
                                      hn::Le(hn::Mul(through, lost), hn::Set(d, 2.0F * mostWrong)));
            const auto even = hn::Le(error, hn::Mul(from.left, hn::Set(d, 8.0F * mostWrong)));
            right = hn::And(right, hn::And(faint, even));  // neither of what is no number
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
    Lanes mostLeft_;                                      // behind what was brought together
    Light light_;
    const CompositeFrame& frame_;
    const Packet& packet_;
    const std::size_t lane_;
    PacketSights& sights_;
    OwnPoints& room_;
    std::size_t most_ = 0;  // of them
};

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
