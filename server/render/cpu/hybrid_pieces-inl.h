// SPDX-License-Identifier: GPL-3.0-or-later
//
// What lies between samples of a hybrid volume, cut into pieces where it is dense, bent or steep
// (docs/PICTURE.md). Compiled once for each target (Highway's foreach_target), hence without #pragma once.
#if defined(MOTE_HYBRID_PIECES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_HYBRID_PIECES_INL_H
#undef MOTE_HYBRID_PIECES_INL_H
#else
#define MOTE_HYBRID_PIECES_INL_H
#endif

#include "server/render/cpu/hybrid_sample-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// What lies between two samples of a hybrid volume, in its light. `length`: of a way of 1.
struct LitPiece {
    V depth;  ///< optical depth, over that of a way of length 1
    V red, green, blue;

    HWY_INLINE LitPiece(const HybridSource& source, const RayLanes& rays, const Piece& piece,
                        const Sample& from, const Sample& to, V length)
        : depth(piece.depth) {
        const Floats d;
        const Blend blend(from, to, piece.mean, hn::Mul(piece.depth, length));
        const auto shade = source.shadeAt(rays, blend(from.way, to.way));
        const V scale = hn::Mul(shade.diffuse, hn::Set(d, colorScale));
        red = hn::MulAdd(blend(from.red, to.red), scale, shade.specular);
        green = hn::MulAdd(blend(from.green, to.green), scale, shade.specular);
        blue = hn::MulAdd(blend(from.blue, to.blue), scale, shade.specular);
    }
};

/// An optical depth of one piece, a change of it by what changes within, and a change of value, as the table
/// counts it, from which on it must be looked at more closely.
constexpr float deepPiece = 0.04F;
constexpr float bentPiece = 0.03F;
constexpr float steepPiece = 0.04F * VolumeTable::cells;
constexpr float mostPiecesOfOne = 16.0F;
/// So many that they are worth cutting; of what was cut once, more.
constexpr float enoughPieces[] = {1.0F, 4.0F};

/// For each ray the one or the other sample.
HWY_INLINE Sample choose(hn::Mask<Floats> first, const Sample& one, const Sample& other) {
    const auto either = [&](V a, V b) HWY_ATTR { return hn::IfThenElse(first, a, b); };
    return {either(one.way, other.way),           either(one.density, other.density),
            either(one.integral, other.integral), either(one.slope, other.slope),
            either(one.red, other.red),           either(one.green, other.green),
            either(one.blue, other.blue)};
}

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

template <int level, class Take>
void takePieces(const HybridSource& source, const RayLanes& rays, const Sample& front, const Sample& back,
                V length, hn::Mask<Floats> alive, const Take& take);

/// Each ray in as many pieces as it wants itself: what its neighbours in the vector want must not show. One
/// that has arrived stays at `back`, where its pieces are empty.
template <int level, class Take>
HWY_INLINE void cutPieces(const HybridSource& source, const RayLanes& rays, const Sample& front,
                          const Sample& back, V wanted, V length, hn::Mask<Floats> alive, const Take& take) {
    const Floats d;
    const V pieces =
        hn::Floor(hn::Add(hn::Min(wanted, hn::Set(d, mostPiecesOfOne - 1.0F)), hn::Set(d, 1.0F)));
    const float most = hn::GetLane(hn::MaxOfLanes(d, pieces));
    const V step = hn::Div(hn::Sub(back.way, front.way), pieces);
    Sample from = front;
    for (float i = 1.0F; i <= most; ++i) {
        const auto arrived = hn::Ge(hn::Set(d, i), pieces);
        const Sample to = hn::AllTrue(d, arrived)
                              ? back
                              : choose(arrived, back, source.sampleAt(rays, hn::Add(from.way, step)));
        takePieces<level + 1>(source, rays, from, to, length, alive, take);
        from = to;
    }
}

/// Hands to `take(LitPiece)` what lies between two samples, in several pieces where some of the rays `alive`
/// want that, and these once more. `length`: of a way of 1.
template <int level = 0, class Take>
HWY_INLINE void takePieces(const HybridSource& source, const RayLanes& rays, const Sample& front,
                           const Sample& back, V length, hn::Mask<Floats> alive, const Take& take) {
    const Floats d;
    const Piece whole(front, back);
    if (hn::AllTrue(d, hn::Le(whole.depth, hn::Zero(d)))) return;
    if constexpr (level < 2) {
        const V wanted = hn::IfThenElseZero(alive, piecesWanted(whole, front, back, length));
        if (!hn::AllTrue(d, hn::Lt(wanted, hn::Set(d, enoughPieces[level]))))
            return cutPieces<level>(source, rays, front, back, wanted, length, alive, take);
    }
    take(LitPiece(source, rays, whole, front, back, length));
}

/// Whether something shows from the front to the middle or from there to the back.
HWY_INLINE hn::Mask<Floats> showsAt(const Sample& middle, const Sample& front, const Sample& back) {
    return hn::Gt(hn::Add(Piece(front, middle).depth, Piece(middle, back).depth), hn::Zero(Floats()));
}

/// Where three samples in equal steps, the density taken as quadratic, have it least or greatest: so far from
/// the middle, of the whole way; at 1/2 or more there is no such place between them.
HWY_INLINE V extremum(const Sample& front, const Sample& middle, const Sample& back) {
    const Floats d;
    const V change = hn::Sub(front.density, back.density);
    const V bend = hn::Sub(hn::Add(front.density, back.density), hn::Add(middle.density, middle.density));
    return hn::Div(change, hn::Mul(hn::Set(d, 4.0F), bend));
}

/// Of a ray that shows nothing at either end, a sample between them that shows something, or the back.
HWY_NOINLINE Sample hiddenBetween(const HybridSource& source, const RayLanes& rays, const Sample& front,
                                  const Sample& back, hn::Mask<Floats> dark) {
    const Floats d;
    const V half = hn::Set(d, 0.5F);
    const V centre = hn::Mul(hn::Add(front.way, back.way), half);
    const Sample middle = source.sampleAt(rays, centre);
    const auto found = hn::And(dark, showsAt(middle, front, back));
    const V offset = extremum(front, middle, back);
    const auto curved = hn::AndNot(found, hn::And(dark, hn::Lt(hn::Abs(offset), half)));
    const Sample there = choose(found, middle, back);
    if (hn::AllFalse(d, curved)) return there;
    const V place = hn::MulAdd(hn::IfThenElseZero(curved, offset), hn::Sub(back.way, front.way), centre);
    const Sample peak = source.sampleAt(rays, place);
    return choose(hn::And(curved, showsAt(peak, front, back)), peak, there);
}

/// As takePieces; where a ray shows nothing at either end it may between them. `fine`: whether pieces are
/// worth it.
template <class Take>
HWY_INLINE void takeHybrid(const HybridSource& source, const RayLanes& rays, const Sample& front,
                           const Sample& back, V length, bool fine, hn::Mask<Floats> alive,
                           const Take& take) {
    const Floats d;
    const Piece whole(front, back);
    const auto dark = hn::Le(whole.depth, hn::Zero(d));
    if (!fine) {
        if (!hn::AllTrue(d, dark)) take(LitPiece(source, rays, whole, front, back, length));
        return;
    }
    const auto unknown = hn::And(hn::And(dark, alive), hn::Gt(back.way, front.way));
    if (!hn::AllFalse(d, unknown)) {
        const Sample there = hiddenBetween(source, rays, front, back, unknown);
        const auto hidden = hn::Lt(there.way, back.way);
        if (!hn::AllFalse(d, hidden)) {
            takePieces(source, rays, choose(hidden, front, back), there, length, alive, take);
            takePieces(source, rays, there, back, length, alive, take);
        }
    }
    takePieces(source, rays, front, back, length, alive, take);
}

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
