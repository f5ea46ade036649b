// SPDX-License-Identifier: GPL-3.0-or-later
//
// SmoothWalk: the way of a vector of a packet's pixels whose fields are told by a TileLattice: only where
// there are points anything is done. What fields and points let through is multiplied, so the light of fields
// between two points is what they alone would give there, times what the points before it let through.
// Compiled once for each target (Highway's foreach_target), hence without #pragma once.
#if defined(MOTE_SMOOTH_WALK_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_SMOOTH_WALK_INL_H
#undef MOTE_SMOOTH_WALK_INL_H
#else
#define MOTE_SMOOTH_WALK_INL_H
#endif

#include "server/render/cpu/composite/light-inl.h"
#include "server/render/cpu/composite/packet.h"
#include "server/render/cpu/composite/slab_points-inl.h"
#include "server/render/cpu/composite/told_nodes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// What is told at a share of the way from one place to another.
HWY_INLINE Light between(const Light& from, const Light& to, V share) {
    const auto mean = [&](V one, V other) HWY_ATTR { return hn::MulAdd(share, hn::Sub(other, one), one); };
    Light light;
    light.left = mean(from.left, to.left);
    light.red = mean(from.red, to.red);
    light.green = mean(from.green, to.green);
    light.blue = mean(from.blue, to.blue);
    return light;
}

/// What fields are between two places: as Matter, evenly spread.
struct Evenly {
    V tau, red, green, blue;

    /// With u = (from - to) / (from + to) of what is left, tau = 2 artanh(u): to a thousandth for u up to
    /// 1/2, beyond it the logarithm.
    HWY_INLINE Evenly(const Light& from, const Light& to) {
        const Floats d;
        const V sum = hn::Max(hn::Add(from.left, to.left), hn::Set(d, 1e-12F));
        const V one = hn::Div(hn::Set(d, 1.0F), sum),
                taken = hn::Max(hn::Sub(from.left, to.left), hn::Zero(d));
        const V u = hn::Mul(taken, one), square = hn::Mul(u, u);
        V series = hn::MulAdd(square, hn::Set(d, 2.0F / 7.0F), hn::Set(d, 2.0F / 5.0F));
        series = hn::MulAdd(square, series, hn::Set(d, 2.0F / 3.0F));
        V scale = hn::Mul(hn::MulAdd(square, series, hn::Set(d, 2.0F)), one);
        const auto much = hn::Gt(u, hn::Set(d, 0.5F));
        if (!hn::AllFalse(d, much)) {
            const V share =
                hn::Div(hn::Max(to.left, hn::Set(d, 1e-12F)), hn::Max(from.left, hn::Set(d, 1e-12F)));
            const V deep = hn::Div(minusLog(share), hn::Max(taken, hn::Set(d, 1e-12F)));
            scale = hn::IfThenElse(much, deep, scale);
        }
        tau = hn::Mul(taken, scale);
        red = hn::Mul(hn::Sub(to.red, from.red), scale);
        green = hn::Mul(hn::Sub(to.green, from.green), scale);
        blue = hn::Mul(hn::Sub(to.blue, from.blue), scale);
    }
};

/// The light of points of one layer, and of what the fields are where they are spread, as of what lets all
/// light through that comes there. `passed`: by the points.
HWY_INLINE void gatherMixed(V tau, const std::array<V, 3>& color, const Light& from, const Light& to,
                            V& passed, Light& light) {
    const Floats d;
    const Evenly fields(from, to);
    passed = expMinus(tau);
    const V all = hn::Add(tau, fields.tau);
    const V lost = hn::Sub(from.left, hn::Mul(passed, to.left));
    const V share = hn::Div(lost, hn::Max(all, hn::Set(d, 1e-30F)));
    light.red = hn::Mul(share, hn::MulAdd(tau, color[0], fields.red));
    light.green = hn::Mul(share, hn::MulAdd(tau, color[1], fields.green));
    light.blue = hn::Mul(share, hn::MulAdd(tau, color[2], fields.blue));
}

class SmoothWalk {
  public:
    /// `lane`: of the packet's pixels, the vector's first.
    HWY_INLINE SmoothWalk(const CompositeFrame& frame, const Packet& packet, const TileLattice& lattice,
                          const ToldNodes& nodes, std::size_t lane)
        : frame_(frame), packet_(packet), lattice_(lattice), nodes_(nodes), lane_(lane) {}

    HWY_INLINE Light run() const {
        const Floats d;
        Light light, passed;                        // `passed`: by the fields alone
        V through = hn::Set(d, 1.0F);               // the points
        Light front, back;                          // at the borders of a slab
        std::size_t told = lattice_.lastRow() + 1;  // the row of `back`
        for (std::uint32_t slab = packet_.nextPoints(0); slab < frame_.slabs;
             slab = packet_.nextPoints(slab + 1)) {
            const std::size_t row = lattice_.row(slab);
            front = told == row ? back : fieldsTo(row);
            back = fieldsTo(told = row + 1);
            addFields(through, passed, front, light);
            addSlab(slab, front, back, through, light);
            passed = back;
            light.left = hn::Mul(through, passed.left);
            if (light.gone()) return light;
            // What ended is not told anew by what its neighbours have behind.
            through = hn::IfThenElseZero(light.seen(), through);
        }
        const Light end = fieldsTo(lattice_.lastRow());
        addFields(through, passed, end, light);
        light.left = hn::Mul(through, end.left);
        light.gone();
        return light;
    }

  private:
    HWY_INLINE Light fieldsTo(std::size_t row) const { return nodes_.at(row, lane_); }

    /// The light of fields between two borders, behind points that let so much through.
    HWY_INLINE static void addFields(V through, const Light& from, const Light& to, Light& light) {
        light.red = hn::MulAdd(through, hn::Sub(to.red, from.red), light.red);
        light.green = hn::MulAdd(through, hn::Sub(to.green, from.green), light.green);
        light.blue = hn::MulAdd(through, hn::Sub(to.blue, from.blue), light.blue);
    }

    /// A slab with points, in which the fields change evenly.
    HWY_INLINE void addSlab(std::uint32_t slab, const Light& front, const Light& back, V& through,
                            Light& light) const {
        SlabPoints points;
        points.read(frame_, packet_, slab, lane_);
        const auto begin = static_cast<float>(slab);
        if (points.count == 1) {
            const Floats d;
            const auto share = [&](const Lanes& place) HWY_ATTR {
                return hn::Max(hn::Sub(hn::Load(d, place.data()), hn::Set(d, begin)), hn::Zero(d));
            };
            const Light from = between(front, back, share(points.from[0]));
            const Light to = between(front, back, share(points.to[0]));
            addFields(through, front, from, light);
            addMixed(points, from, to, through, light);
            addFields(through, to, back, light);
        } else {
            addLayers(points, begin, front, back, through, light);
        }
    }

    /// Points of one layer among what the fields are where they are spread.
    HWY_INLINE static void addMixed(const SlabPoints& points, const Light& from, const Light& to, V& through,
                                    Light& light) {
        const Floats d;
        const auto color = [&](std::size_t c) HWY_ATTR { return hn::Load(d, points.color[0][c]); };
        Light mixed;
        V passed;
        gatherMixed(hn::Load(d, points.tau[0].data()), {color(0), color(1), color(2)}, from, to, passed,
                    mixed);
        light.red = hn::MulAdd(through, mixed.red, light.red);
        light.green = hn::MulAdd(through, mixed.green, light.green);
        light.blue = hn::MulAdd(through, mixed.blue, light.blue);
        through = hn::Mul(through, passed);
    }

    /// Points of several layers, with cuts where those of each begin and end.
    HWY_NOINLINE static void addLayers(const SlabPoints& points, float begin, const Light& front,
                                       const Light& back, V& through, Light& light) {
        const Floats d;
        const Evenly fields(front, back);
        light.left = hn::Mul(through, front.left);
        V at = hn::Set(d, begin), depth = hn::Zero(d);
        const V end = hn::Set(d, begin + 1.0F);
        while (!hn::AllFalse(d, hn::Lt(at, end))) {
            V next = points.nextCut(at, end);
            next = hn::Min(hn::Max(next, hn::Add(at, hn::Set(d, 1e-4F))), end);
            const V share = hn::Sub(next, at);
            Matter matter;
            matter.tau = hn::Mul(share, fields.tau);
            matter.red = hn::Mul(share, fields.red);
            matter.green = hn::Mul(share, fields.green);
            matter.blue = hn::Mul(share, fields.blue);
            points.addSpread(at, next, matter);
            light.gather(matter);
            Matter single;
            points.addSingle(at, next, single);
            light.gather(single);
            at = next;
        }
        for (std::size_t i = 0; i < points.count; ++i)
            depth = hn::Add(depth, hn::Load(d, points.tau[i].data()));
        through = hn::Mul(through, expMinus(depth));
    }

    const CompositeFrame& frame_;
    const Packet& packet_;
    const TileLattice& lattice_;
    const ToldNodes& nodes_;
    const std::size_t lane_;
};

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
