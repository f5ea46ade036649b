// SPDX-License-Identifier: GPL-3.0-or-later
//
// What rays meet on a way through a cell of a field of samples, in pieces where it is dense, bent or steep
// (docs/PICTURE.md). Compiled once for each target (Highway's foreach_target), hence without #pragma once.
#if defined(MOTE_LIT_PATH_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_LIT_PATH_INL_H
#undef MOTE_LIT_PATH_INL_H
#else
#define MOTE_LIT_PATH_INL_H
#endif

#include <algorithm>

#include "server/render/cpu/composite/cubic-inl.h"
#include "server/render/cpu/composite/grid_cell-inl.h"
#include "server/render/cpu/composite/piece_list-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// What is in the chosen lanes.
HWY_INLINE Sample of(const Sample& sample, const LaneChoice& lanes) {
    return {of(sample.way, lanes),   of(sample.density, lanes), of(sample.integral, lanes),
            of(sample.slope, lanes), of(sample.red, lanes),     of(sample.green, lanes),
            of(sample.blue, lanes)};
}
HWY_INLINE Cubic of(const Cubic& cubic, const LaneChoice& lanes) {
    return {of(cubic.c0, lanes), of(cubic.c1, lanes), of(cubic.c2, lanes), of(cubic.c3, lanes)};
}

/// The one or the other sample, by ray.
HWY_INLINE Sample choose(hn::Mask<Floats> first, const Sample& one, const Sample& other) {
    const auto either = [&](V a, V b) HWY_ATTR { return hn::IfThenElse(first, a, b); };
    return {either(one.way, other.way),           either(one.density, other.density),
            either(one.integral, other.integral), either(one.slope, other.slope),
            either(one.red, other.red),           either(one.green, other.green),
            either(one.blue, other.blue)};
}

/// What lies between two samples of a field of samples, in its light.
struct LitPiece {
    V depth;  ///< optical
    V red, green, blue;

    /// `shadeAt(way)`; `length`: of a way of 1.
    template <class ShadeAt>
    HWY_INLINE LitPiece(const ShadeAt& shadeAt, const Piece& piece, const Sample& from, const Sample& to,
                        V length) {
        const V whole = hn::Mul(piece.depth, length);
        const Blend blend(from, to, piece.mean, whole);
        const Shade shade = shadeAt(blend(from.way, to.way));
        depth = hn::Mul(whole, shade.share);
        const V scale = hn::Mul(shade.diffuse, hn::Set(Floats(), colorScale));
        red = hn::MulAdd(blend(from.red, to.red), scale, shade.specular);
        green = hn::MulAdd(blend(from.green, to.green), scale, shade.specular);
        blue = hn::MulAdd(blend(from.blue, to.blue), scale, shade.specular);
    }
};

/// An optical depth of one piece, a change of it by what changes within, and a change of value, as the table
/// counts it, from which on it must be looked at more closely.
constexpr float deepPiece = 0.2F;
constexpr float bentPiece = 0.03F;
constexpr float steepPiece = 0.05F * TransferTable::cells;
/// So many that what was cut once is worth cutting again.
constexpr float enoughPieces = 2.0F;

/// Into how many pieces a ray wants what lies between two samples to be cut, before it is rounded: where it
/// is dense, where extinction bends, where the value is steep. 0 where nothing shows. `length`: of a way
/// of 1.
HWY_INLINE V piecesWanted(const Piece& whole, const Sample& front, const Sample& back, V length) {
    const Floats d;
    const V change = hn::Mul(hn::Abs(hn::Sub(back.density, front.density)), hn::Set(d, 1.0F / steepPiece));
    const V depth = hn::Mul(hn::Mul(whole.depth, length), hn::Set(d, 1.0F / deepPiece));
    // A wrong value between the two costs what extinction would have changed by.
    const V level = hn::Mul(hn::Add(front.slope, back.slope), hn::Set(d, 0.5F));
    const V bend = hn::MulAdd(hn::Abs(hn::Sub(whole.mean, level)), hn::Set(d, 4.0F),
                              hn::Abs(hn::Sub(back.slope, front.slope)));
    const V bent =
        hn::Mul(hn::Mul(bend, hn::Sub(back.way, front.way)), hn::Mul(length, hn::Set(d, 1.0F / bentPiece)));
    return hn::IfThenElseZero(hn::Gt(whole.depth, hn::Zero(d)), hn::Max(hn::Max(change, bent), depth));
}

/// How many there are of what is wanted, at least 1.
HWY_INLINE V pieceCount(V wanted) {
    const Floats d;
    return hn::Floor(hn::Add(hn::Min(wanted, hn::Set(d, PieceSpans::mostPieces - 1.0F)), hn::Set(d, 1.0F)));
}

/// A way through a cell, by s from 0 at its front to 1 at its back.
struct LitPath {
    const GridSource& source;
    Cubic density, diffuse, specular, share;  ///< `share`: where slopes are asked for
    Sample front;                             ///< its way: s
    V length;                                 ///< of the way

    HWY_INLINE bool sloped() const { return source.samples().slopes != nullptr; }
    HWY_INLINE Sample sampleAt(V s, const LaneChoice& rays) const {
        return source.sampleWith(s, of(density, rays).at(s));
    }
    HWY_INLINE Shade shadeAt(V s, const LaneChoice& rays) const {
        return {of(diffuse, rays).at(s), of(specular, rays).at(s),
                sloped() ? of(share, rays).at(s) : hn::Set(Floats(), 1.0F)};
    }
    /// Of the chosen rays, from a sample on.
    HWY_INLINE LitPath from(const Sample& sample, const LaneChoice& rays) const {
        return {source, of(density, rays), of(diffuse, rays), of(specular, rays), of(share, rays),
                sample, of(length, rays)};
    }
};

/// What pieces come to: of light what is gained and what is left, or of matter colour times optical depth,
/// and that depth.
struct PieceSum {
    V red, green, blue, rest;
};
HWY_INLINE PieceSum of(const PieceSum& sum, const LaneChoice& lanes) {
    return {of(sum.red, lanes), of(sum.green, lanes), of(sum.blue, lanes), of(sum.rest, lanes)};
}
HWY_INLINE PieceSum choose(hn::Mask<Floats> first, const PieceSum& one, const PieceSum& other) {
    const auto either = [&](V a, V b) HWY_ATTR { return hn::IfThenElse(first, a, b); };
    return {either(one.red, other.red), either(one.green, other.green), either(one.blue, other.blue),
            either(one.rest, other.rest)};
}

/// Gathers light, front to back.
struct LightSums {
    Light& light;

    HWY_INLINE static PieceSum none() {
        const Light light;
        return {light.red, light.green, light.blue, light.left};
    }
    HWY_INLINE static PieceSum of(const LitPiece& piece) {
        Light gained;
        gained.gather(piece.depth, piece.red, piece.green, piece.blue);
        return {gained.red, gained.green, gained.blue, gained.left};
    }
    /// What comes first, and what is seen through it.
    HWY_INLINE static PieceSum join(const PieceSum& first, const PieceSum& then) {
        return {hn::MulAdd(first.rest, then.red, first.red), hn::MulAdd(first.rest, then.green, first.green),
                hn::MulAdd(first.rest, then.blue, first.blue), hn::Mul(first.rest, then.rest)};
    }
    HWY_INLINE void take(const PieceSum& sum) const {
        light.red = hn::MulAdd(light.left, sum.red, light.red);
        light.green = hn::MulAdd(light.left, sum.green, light.green);
        light.blue = hn::MulAdd(light.left, sum.blue, light.blue);
        light.left = hn::Mul(light.left, sum.rest);
    }
    HWY_INLINE void take(const LitPiece& piece) const { take(of(piece)); }
};

/// Adds up matter that is mixed evenly.
struct MatterSums {
    Matter& matter;

    HWY_INLINE static PieceSum none() {
        const V zero = hn::Zero(Floats());
        return {zero, zero, zero, zero};
    }
    HWY_INLINE static PieceSum of(const LitPiece& piece) {
        return {hn::Mul(piece.depth, piece.red), hn::Mul(piece.depth, piece.green),
                hn::Mul(piece.depth, piece.blue), piece.depth};
    }
    HWY_INLINE static PieceSum join(const PieceSum& one, const PieceSum& other) {
        return {hn::Add(one.red, other.red), hn::Add(one.green, other.green), hn::Add(one.blue, other.blue),
                hn::Add(one.rest, other.rest)};
    }
    HWY_INLINE void take(const PieceSum& sum) const {
        matter.red = hn::Add(matter.red, sum.red);
        matter.green = hn::Add(matter.green, sum.green);
        matter.blue = hn::Add(matter.blue, sum.blue);
        matter.tau = hn::Add(matter.tau, sum.rest);
    }
    HWY_INLINE void take(const LitPiece& piece) const { take(of(piece)); }
};

/// Joins what came before of each ray with its pieces in a vector, one after the other: sums are the same by
/// vectors of any width. `first`: the number of the vector's first piece.
template <class Sums>
HWY_INLINE PieceSum join(PieceSum sums, const PieceSum& pieces, const PieceList& list, std::size_t first) {
    constexpr int together = 4;  // steps between two looks for whether there is another
    const Floats d;
    const auto lanes = list.lanesOf(first);
    V lane = lanes.begin;
    do {
        for (int i = 0; i < together; ++i) {
            const auto some = hn::Lt(lane, lanes.end);
            sums = choose(some, Sums::join(sums, of(pieces, chosen(lane))), sums);
            lane = hn::Add(lane, hn::Set(d, 1.0F));
        }
    } while (!hn::AllFalse(d, hn::Lt(lane, lanes.end)));
    return sums;
}

/// What the pieces of each ray come to, of the rays in `shown`. Those that turn out to want it are cut
/// `again`.
template <class Sums, bool again = true>
HWY_INLINE PieceSum sumPieces(const LitPath& path, const PieceSpans& spans, hn::Mask<Floats> shown);

/// The same of what lies between samples, cut into as many pieces as are wanted. `rays`: whose they are.
template <class Sums>
HWY_NOINLINE PieceSum cutAgain(const LitPath& path, const LaneChoice& rays, const Sample& from,
                               const Sample& to, V wanted, hn::Mask<Floats> which) {
    PieceSpans spans;
    spans.add(from.way, to.way, pieceCount(wanted));
    return sumPieces<Sums, false>(path.from(from, rays), spans, which);
}

template <class Sums, bool again>
HWY_INLINE PieceSum sumPieces(const LitPath& path, const PieceSpans& spans, hn::Mask<Floats> shown) {
    const Floats d;
    const PieceList list(hn::IfThenElseZero(shown, spans.count()));
    PieceSum sums = Sums::none();
    Sample before = path.front;
    for (std::size_t first = 0; first < list.size(); first += laneCount) {
        const LaneChoice rays = list.rays(first);
        const V numbers = list.numbers(first);
        const Sample to = path.sampleAt(spans.endOf(numbers, rays), rays);
        const Sample moved = of(to, lanesBefore(1));
        const Sample from = choose(hn::Eq(numbers, hn::Zero(d)), of(path.front, rays),
                                   choose(hn::FirstN(d, 1), before, moved));
        before = moved;
        const Piece whole(from, to);
        const V length = of(path.length, rays);
        const auto shadeAt = [&](V s) HWY_ATTR { return path.shadeAt(s, rays); };
        PieceSum pieces = Sums::of(LitPiece(shadeAt, whole, from, to, length));
        if constexpr (again) {
            const V wanted = piecesWanted(whole, from, to, length);
            const auto counts = hn::FirstN(d, std::min(laneCount, list.size() - first));
            const auto many = hn::And(counts, hn::Ge(wanted, hn::Set(d, enoughPieces)));
            if (!hn::AllFalse(d, many))
                pieces = choose(many, cutAgain<Sums>(path, rays, from, to, wanted, many), pieces);
        }
        sums = join<Sums>(sums, pieces, list, first);
    }
    return sums;
}

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
