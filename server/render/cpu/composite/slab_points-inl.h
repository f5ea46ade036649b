// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a vector of rays meets beside fields: the points of all layers in one slab of a packet (SlabPoints),
// and the dots of its pixels (DotCursor). Compiled once for each target (Highway's foreach_target), hence
// without #pragma once.
#if defined(MOTE_SLAB_POINTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_SLAB_POINTS_INL_H
#undef MOTE_SLAB_POINTS_INL_H
#else
#define MOTE_SLAB_POINTS_INL_H
#endif

#include "server/render/cpu/composite/light-inl.h"
#include "server/render/cpu/composite/packet.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Where a vector of rays stands among the dots of its pixels, front to back.
class DotCursor {
  public:
    /// `lane`: of the packet's pixels, the vector's first.
    HWY_INLINE DotCursor(const Packet& packet, std::size_t lane) {
        hn::Store(hn::Set(Floats(), beyond), Floats(), next_.data());
        if (packet.dots == nullptr) return;
        for (std::size_t i = 0; i < hn::Lanes(Floats()); ++i) {
            left_[i] =
                packet.dots->of(packet.number * Tile::packetPixels + static_cast<std::uint32_t>(lane + i));
            if (!left_[i].empty()) next_[i] = left_[i].front().place;
        }
    }

    /// The depth of the next dot, where it lies before `end`.
    HWY_INLINE V nextCut(V end) const { return hn::Min(hn::Load(Floats(), next_.data()), end); }

    /// Gathers the dots up to a depth.
    HWY_NOINLINE void pass(V to, Light& light) {
        const Floats d;
        if (hn::AllFalse(d, hn::Le(hn::Load(d, next_.data()), to))) return;
        Lanes depth, red{}, green{}, blue{}, passed;
        hn::Store(to, d, depth.data());
        for (std::size_t i = 0; i < hn::Lanes(d); ++i) {
            passed[i] = 1.0F;
            while (next_[i] <= depth[i]) {
                const DotHit& hit = left_[i].front();
                const float share = passed[i] * hit.opacity;
                red[i] += share * hit.color.x;
                green[i] += share * hit.color.y;
                blue[i] += share * hit.color.z;
                passed[i] -= share;
                left_[i] = left_[i].subspan(1);
                next_[i] = left_[i].empty() ? beyond : left_[i].front().place;
            }
        }
        light.red = hn::MulAdd(light.left, hn::Load(d, red.data()), light.red);
        light.green = hn::MulAdd(light.left, hn::Load(d, green.data()), light.green);
        light.blue = hn::MulAdd(light.left, hn::Load(d, blue.data()), light.blue);
        light.left = hn::Mul(light.left, hn::Load(d, passed.data()));
    }

  private:
    static constexpr float beyond = 1e30F;  // of a pixel without further dots, slabs

    Lanes next_;  // depth of each ray's next dot
    std::array<std::span<const DotHit>, Tile::packetPixels> left_{};
};

/// n points scattered evenly over a slab span (n - 1) / (n + 1) of it: so far around their mean depth they
/// are spread; a single one stays where it is. Places are shares of the slab.
struct SpreadPoints {
    V tau;        ///< optical depth of all
    V near, far;  ///< where they begin and end; the same where they are alone, also after rounding

    /// As a PointCell has them, in a slab.
    HWY_INLINE SpreadPoints(V weight, V moment, const FramePointLook& look, V slabNearest, V slabThickness) {
        const Floats d;
        const V one = hn::Set(d, 1.0F), zero = hn::Zero(d);
        const V least = hn::Set(d, 1.0F / 64.0F);  // a slab's share that points are spread over at least
        const V mean = hn::Div(moment, hn::Max(weight, hn::Set(d, 1e-30F)));
        const V middle = hn::Min(hn::Max(mean, least), one);
        tau = hn::Mul(weight, tauOfOne(look, slabNearest, slabThickness, mean));
        const V spread = hn::IfThenElse(hn::Lt(weight, hn::Set(d, 1.5F)), zero,
                                        hn::Div(hn::Sub(weight, one), hn::Add(weight, one)));
        const V half = hn::Mul(spread, hn::Set(d, 0.5F));
        near = hn::Max(hn::Sub(middle, half), zero);
        far = hn::Min(hn::Add(middle, half), one);
    }

  private:
    /// Of points that stand so far, a share, into the slab.
    HWY_INLINE static V tauOfOne(const FramePointLook& look, V nearest, V thickness, V share) {
        const V tau = hn::Set(Floats(), look.tau);
        if (!look.byDepth) return tau;
        const V depth = hn::MulAdd(share, thickness, nearest);
        return hn::Div(tau, hn::Mul(depth, depth));
    }
};

/// The points of all layers that a vector of rays meets in one slab.
struct alignas(64) SlabPoints {
    // The lanes first: they are loaded as vectors, which must lie as the struct itself is aligned.
    std::array<Lanes, View::maxLayers> from, to;     ///< slabs; both -1 where a ray meets none
    std::array<Lanes, View::maxLayers> density;      ///< optical depth a slab of those that are spread
    std::array<Lanes, View::maxLayers> single;       ///< optical depth of one in one place, at `to`
    std::array<Lanes, View::maxLayers> tau;          ///< optical depth of all
    std::size_t count = 0;                           ///< layers that have points here
    std::array<std::size_t, View::maxLayers> layer;  ///< which
    /// Red, green and blue of this vector's pixels; the packet's.
    std::array<std::array<const float*, 3>, View::maxLayers> color;

    /// Returns the layers that have points, as bits.
    HWY_INLINE std::uint32_t read(const CompositeFrame& frame, const Packet& packet, std::uint32_t slab,
                                  std::size_t lane) {
        std::uint32_t layers = 0;
        for (std::size_t l = 0; l < packet.points.size(); ++l) {
            if (!packet.hasPoints(l, slab)) continue;
            layer[count] = l;
            for (std::size_t c = 0; c < 3; ++c) color[count][c] = packet.pointColors[l][c].data() + lane;
            readLayer(packet.cells(l, slab) + lane, frame.points[l], frame.depths[slab],
                      static_cast<float>(slab));
            layers |= 1U << l;
        }
        return layers;
    }

    HWY_INLINE void readLayer(const PointCell* cells, const FramePointLook& look, const SlabDepth& depth,
                              float slab) {
        const Floats d;
        static_assert(sizeof(PointCell) == 2 * sizeof(float));
        V weight, moment;
        hn::LoadInterleaved2(d, &cells->weight, weight, moment);
        const SpreadPoints spread(weight, moment, look, hn::Set(d, depth.nearest),
                                  hn::Set(d, depth.thickness));
        const V zero = hn::Zero(d), start = hn::Set(d, slab), all = spread.tau;
        const V near = hn::Add(start, spread.near), far = hn::Add(start, spread.far);
        const auto none = hn::Le(weight, zero);
        const auto alone = hn::Le(far, near);  // also where both are the same after rounding
        const V absent = hn::Set(d, -1.0F);
        hn::Store(hn::IfThenElse(none, absent, near), d, from[count].data());
        hn::Store(hn::IfThenElse(none, absent, hn::Max(far, near)), d, to[count].data());
        hn::Store(hn::IfThenElse(alone, zero, hn::Div(all, hn::Sub(far, near))), d, density[count].data());
        hn::Store(hn::IfThenElse(alone, all, zero), d, single[count].data());
        hn::Store(all, d, tau[count].data());
        ++count;
    }

    /// The nearest depth behind `at` where points begin or end; at most `end`.
    HWY_INLINE V nextCut(V at, V end) const {
        const Floats d;
        V next = end;
        for (std::size_t i = 0; i < count; ++i) {
            for (const Lanes* cuts : {&from[i], &to[i]}) {
                const V cut = hn::Load(d, cuts->data());
                next = hn::IfThenElse(hn::Gt(cut, at), hn::Min(next, cut), next);
            }
        }
        return next;
    }

    HWY_INLINE void addSpread(V at, V next, Matter& matter) const {
        const Floats d;
        for (std::size_t i = 0; i < count; ++i) {
            const auto within =
                hn::And(hn::Le(hn::Load(d, from[i].data()), at), hn::Gt(hn::Load(d, to[i].data()), at));
            const V depth = hn::Mul(hn::Load(d, density[i].data()), hn::Sub(next, at));
            matter.add(hn::IfThenElseZero(within, depth), hn::Load(d, color[i][0]), hn::Load(d, color[i][1]),
                       hn::Load(d, color[i][2]));
        }
    }

    /// A single point ends the segment before it.
    HWY_INLINE void addSingle(V at, V next, Matter& matter) const {
        const Floats d;
        for (std::size_t i = 0; i < count; ++i) {
            const V place = hn::Load(d, from[i].data());
            const auto met = hn::And(hn::Gt(place, at), hn::Le(place, next));
            matter.add(hn::IfThenElseZero(met, hn::Load(d, single[i].data())), hn::Load(d, color[i][0]),
                       hn::Load(d, color[i][1]), hn::Load(d, color[i][2]));
        }
    }
};

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
