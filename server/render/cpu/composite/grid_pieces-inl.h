// SPDX-License-Identifier: GPL-3.0-or-later
//
// What rays meet in a cell of a field of samples, in pieces where it is dense, bent or steep
// (docs/PICTURE.md). Compiled once for each target (Highway's foreach_target), hence without #pragma once.
#if defined(MOTE_GRID_PIECES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_GRID_PIECES_INL_H
#undef MOTE_GRID_PIECES_INL_H
#else
#define MOTE_GRID_PIECES_INL_H
#endif

#include "server/render/cpu/composite/grid_cell-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// What lies between two samples of a field of samples, in its light. `shadeAt(way)`; `length`: of a way
/// of 1.
struct LitPiece {
    V depth;  ///< optical depth, over that of a way of length 1
    V red, green, blue;

    template <class ShadeAt>
    HWY_INLINE LitPiece(const ShadeAt& shadeAt, const Piece& piece, const Sample& from, const Sample& to,
                        V length)
        : depth(piece.depth) {
        const Floats d;
        const Blend blend(from, to, piece.mean, hn::Mul(piece.depth, length));
        const Shade shade = shadeAt(blend(from.way, to.way));
        depth = hn::Mul(depth, shade.share);
        const V scale = hn::Mul(shade.diffuse, hn::Set(d, colorScale));
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
constexpr float mostPiecesOfOne = 16.0F;
/// So much may a density's change differ from an even one, as the table counts it.
constexpr float bentDensity = 0.0025F * TransferTable::cells;
/// So many that they are worth cutting; of what was cut once, more.
constexpr float enoughPieces[] = {1.0F, 2.0F};

/// The one or the other sample, by ray.
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

/// The density along rays through a cell: in s, from 0 at the front to 1 at the back of the way, the cubic
/// ((c3 s + c2) s + c1) s + the front's.
struct CellPath {
    const Sample &front, &back;
    V way;
    V c1, c2, c3;

    /// `y1`, `y2`: the density at both thirds. `even`: the rays along which it is taken as linear, whatever
    /// these say: a cubic through a kink would leave the range of the cell's corners.
    HWY_INLINE CellPath(const Sample& first, V y1, V y2, const Sample& last, hn::Mask<Floats> even)
        : front(first), back(last), way(hn::Sub(back.way, front.way)) {
        const Floats d;
        const V ends = hn::Sub(back.density, front.density), thirds = hn::Sub(y2, y1);
        const V third = hn::Mul(hn::Sub(ends, hn::Mul(thirds, hn::Set(d, 3.0F))), hn::Set(d, 4.5F));
        const V bend = hn::Mul(hn::Sub(hn::Sub(y1, front.density), thirds), hn::Set(d, -4.5F));
        c3 = hn::IfThenZeroElse(even, third);
        c2 = hn::IfThenZeroElse(even, hn::Sub(bend, third));
        c1 = hn::Sub(hn::Sub(ends, c2), c3);
    }
    HWY_INLINE V wayAt(V s) const { return hn::MulAdd(s, way, front.way); }
    HWY_INLINE V densityAt(V s) const {
        return hn::MulAdd(hn::MulAdd(hn::MulAdd(c3, s, c2), s, c1), s, front.density);
    }
};

/// A way through a cell, in light. `length`: of a way of 1; `lit`: the rays that may see something of it, all
/// others meet nothing.
struct LitPath {
    const GridSource& source;
    const CellPath& path;
    const CellLight& light;
    V length;
    hn::Mask<Floats> lit;

    HWY_INLINE Sample sampleAt(V way) const {
        const Floats d;
        const V share = hn::Div(hn::Sub(way, path.front.way), hn::Max(path.way, hn::Set(d, 1e-12F)));
        return source.sampleWith(way, path.densityAt(share));
    }
    HWY_INLINE LitPiece piece(const Piece& piece, const Sample& from, const Sample& to) const {
        LitPiece own([&](V way) HWY_ATTR { return light.shadeAt(way); }, piece, from, to, length);
        own.depth = hn::IfThenElseZero(lit, own.depth);
        return own;
    }
    HWY_INLINE bool showsNothing(V depth) const {
        return hn::AllFalse(Floats(), hn::And(lit, hn::Gt(depth, hn::Zero(Floats()))));
    }
};

template <int level, class Take>
void takePieces(const LitPath& path, const Sample& front, const Sample& back, const Take& take);

/// Each ray in as many pieces as it wants itself: what its neighbours in the vector want must not show. One
/// that has arrived stays at `back`, where its pieces are empty. `wanted`: 0 of rays that want one.
template <int level, class Take>
HWY_INLINE void cutPieces(const LitPath& path, const Sample& front, const Sample& back, V wanted,
                          const Take& take) {
    const Floats d;
    const V pieces =
        hn::Floor(hn::Add(hn::Min(wanted, hn::Set(d, mostPiecesOfOne - 1.0F)), hn::Set(d, 1.0F)));
    const float most = hn::GetLane(hn::MaxOfLanes(d, pieces));
    const V step = hn::Div(hn::Sub(back.way, front.way), pieces);
    Sample from = front;
    float i = 0.0F;
    while (++i <= most) {
        const auto arrived = hn::Ge(hn::Set(d, i), pieces);
        const Sample to =
            hn::AllTrue(d, arrived) ? back : choose(arrived, back, path.sampleAt(hn::Add(from.way, step)));
        takePieces<level + 1>(path, from, to, take);
        from = to;
    }
}

/// Hands to `take(LitPiece)` what lies between two samples of a cell, in several pieces where some of the
/// rays want that, and these once more.
template <int level = 0, class Take>
HWY_INLINE void takePieces(const LitPath& path, const Sample& front, const Sample& back, const Take& take) {
    const Floats d;
    const Piece whole(front, back);
    if (path.showsNothing(whole.depth)) return;
    if constexpr (level < 2) {
        const V wanted = piecesWanted(whole, front, back, path.length);
        const auto many = hn::And(path.lit, hn::Ge(wanted, hn::Set(d, enoughPieces[level])));
        if (!hn::AllFalse(d, many))
            return cutPieces<level>(path, front, back, hn::IfThenElseZero(many, wanted), take);
    }
    take(path.piece(whole, front, back));
}

/// Where to cut a way through a cell, as shares of it: between cuts the density only rises or only falls, so
/// that no sheet is passed by. What bends without that is cut in the middle.
struct MonotoneCuts {
    V first, second;  ///< 1 where there is none
    hn::Mask<Floats> once, twice;

    HWY_INLINE explicit MonotoneCuts(const CellPath& path) {
        const Floats d;
        const V zero = hn::Zero(d), one = hn::Set(d, 1.0F);
        once = hn::Gt(hn::Add(hn::Abs(path.c2), hn::Abs(path.c3)), hn::Set(d, bentDensity));
        twice = hn::FirstN(d, 0);
        first = second = one;
        if (hn::AllFalse(d, once)) return;
        // The derivative is c1 + 2 c2 s + 3 c3 s^2.
        const V three = hn::Mul(path.c3, hn::Set(d, 3.0F));
        const V square = hn::Sub(hn::Mul(path.c2, path.c2), hn::Mul(three, path.c1));
        const V root = hn::Sqrt(hn::Max(square, zero));
        const V far = hn::Neg(hn::Add(path.c2, hn::CopySign(root, path.c2)));
        const auto counts = [&](V s) HWY_ATTR {
            return hn::And(hn::And(once, hn::Ge(square, zero)), hn::And(hn::Gt(s, zero), hn::Lt(s, one)));
        };
        const V s = hn::Div(far, three), t = hn::Div(path.c1, far);
        const auto atS = counts(s), atT = counts(t);
        twice = hn::And(atS, atT);
        first = hn::IfThenElse(atS, s, hn::IfThenElse(atT, t, hn::Set(d, 0.5F)));
        first = hn::IfThenElse(once, hn::IfThenElse(twice, hn::Min(s, t), first), one);
        second = hn::IfThenElse(twice, hn::Max(s, t), one);
    }
};

/// Hands to `take(LitPiece)` what rays meet on a path in a cell. `light`: the cell's, once it is needed.
template <class Take>
HWY_INLINE void takePath(const FieldCell& cell, const CellPath& path, V length, hn::Mask<Floats> lit,
                         CellLight& light, const Take& take) {
    const Floats d;
    const GridSource& source = cell.source();
    const Sample &front = path.front, &back = path.back;
    const MonotoneCuts cuts(path);
    const auto sampleAt = [&](hn::Mask<Floats> cut, V s) HWY_ATTR {
        return choose(cut, source.sampleWith(path.wayAt(s), path.densityAt(s)), back);
    };
    const bool once = !hn::AllFalse(d, cuts.once), twice = !hn::AllFalse(d, cuts.twice);
    const Sample first = once ? sampleAt(cuts.once, cuts.first) : back;
    const Sample second = twice ? sampleAt(cuts.twice, cuts.second) : back;
    V seen = Piece(front, first).depth;
    if (once) seen = hn::Add(seen, Piece(first, second).depth);
    if (twice) seen = hn::Add(seen, Piece(second, back).depth);
    const LitPath all{source, path, light, length, lit};
    if (all.showsNothing(seen)) return;
    light.readOnce(cell);
    takePieces(all, front, first, take);
    if (once) takePieces(all, first, second, take);
    if (twice) takePieces(all, second, back, take);
}

/// The same of what rays meet in a cell from a sample to a way, path by path. Returns a sample there.
/// `even`: the rays to which its density does not change much.
template <class Take>
HWY_INLINE Sample takeCell(const FieldCell& cell, const ThreeAxes& rays, Sample front, V end, V length,
                           hn::Mask<Floats> lit, hn::Mask<Floats> even, const Take& take) {
    const Floats d;
    CellLight light;
    do {
        // However close the kinks, each step must go on in single precision.
        const V smooth = hn::Max(cell.smoothFrom(rays, front.way), hn::Add(front.way, hn::Set(d, 1e-7F)));
        const V next = hn::Min(hn::IfThenElse(even, end, smooth), end);
        const V third = hn::Mul(hn::Sub(next, front.way), hn::Set(d, 1.0F / 3.0F));
        const V y1 = cell.densityAt(hn::Add(front.way, third)), y2 = cell.densityAt(hn::Sub(next, third));
        const Sample back = cell.sampleAt(next);
        takePath(cell, CellPath(front, y1, y2, back, even), length, lit, light, take);
        front = back;
    } while (!hn::AllTrue(d, hn::Ge(front.way, end)));
    return front;
}

/// The cell that rays come to in which something may show, as far as it is known. Those that pass others on
/// the way have a new front, which is not known, and end if they come to `end`.
HWY_INLINE GridPlace placeAhead(const GridSamples& samples, const ThreeAxes& rays, V end,
                                hn::Mask<Floats>& alive, Sample& front, hn::Mask<Floats>& known) {
    const Floats d;
    if (samples.dark == nullptr) return GridPlace(samples, rays, front.way);
    const LitCells cells(samples, rays, end, alive, front.way);
    known = hn::AndNot(cells.moved, known);
    front.slope = hn::IfThenZeroElse(cells.moved, front.slope);
    alive = hn::AndNot(cells.behind, hn::And(alive, hn::Lt(front.way, end)));
    const auto elsewhere = hn::RebindMask(d, hn::Lt(cells.place, hn::Zero(Ints())));
    if (hn::AllFalse(d, hn::And(alive, elsewhere))) return GridPlace(rays, cells);
    return GridPlace(samples, rays, front.way);
}

/// The rays in whose cell nothing shows. Of corrected ones that is known before they come there.
HWY_INLINE hn::Mask<Floats> darkCells(const GridSource& source, const GridPlace& place,
                                      const FieldCell::Range& range) {
    const bool known = source.samples().dark != nullptr;
    if (known && place.all) return hn::FirstN(Floats(), 0);
    const auto dark = source.showsNothing(range.low, range.high);
    return known ? hn::AndNot(place.corrected, dark) : dark;
}

/// The same from a sample to a way, through all cells between. `seen()`: the rays that see something yet.
/// What a ray meets, and the slope at its end, do not depend on its neighbours in the vector.
template <class Seen, class Take>
HWY_INLINE Sample takeCells(const GridSource& source, const ThreeAxes& rays, const Sample& from, V end,
                            V length, const Seen& seen, const Take& take) {
    const Floats d;
    Sample front = from;
    hn::Mask<Floats> kind = hn::FirstN(d, 0);  // of the cell before
    hn::Mask<Floats> known = kind;             // the front was sampled in one of that kind
    const auto going = [&]() HWY_ATTR { return hn::And(seen(), hn::Lt(front.way, end)); };
    for (auto alive = going(); !hn::AllFalse(d, alive); alive = going()) {
        const GridPlace place = placeAhead(source.samples(), rays, end, alive, front, known);
        if (hn::AllFalse(d, alive)) continue;
        const FieldCell cell(source, place);
        const auto range = cell.range();
        const auto dark = darkCells(source, place, range);
        const auto lit = hn::AndNot(dark, alive);
        const V darkSlope = hn::IfThenZeroElse(alive, front.slope);
        // However close the planes, each step must go on in single precision.
        const V next = hn::Min(hn::Max(place.leave, hn::Add(front.way, hn::Set(d, 1e-7F))), end);
        const V leave = hn::IfThenElse(alive, next, front.way);
        if (hn::AllFalse(d, lit)) {
            known = lit;
            front.way = leave;
            front.slope = darkSlope;
            continue;
        }
        // Where it is another grid's cell, the density begins anew.
        known = hn::AndNot(hn::Xor(kind, place.corrected), known);
        if (!hn::AllFalse(d, hn::AndNot(known, lit))) front = choose(known, front, cell.sampleAt(front.way));
        const auto even = hn::Or(dark, hn::Lt(hn::Sub(range.high, range.low), hn::Set(d, bentDensity)));
        front = takeCell(cell, rays, front, leave, length, lit, even, take);
        front.slope = hn::IfThenElse(lit, front.slope, darkSlope);
        kind = place.corrected;
        known = lit;
    }
    return front;
}

/// A sample of what rays come to at a way.
HWY_INLINE Sample sampleAt(const GridSource& source, const ThreeAxes& rays, V way) {
    const GridPlace place(source.samples(), rays, way);
    return FieldCell(source, place).sampleAt(way);
}

/// Hands to `take(LitPiece)` what lies between any two samples as one piece; what shows only between them is
/// passed by.
template <class Take>
HWY_INLINE void takeEvenly(const GridSource& source, const ThreeAxes& rays, const Sample& front,
                           const Sample& back, V length, const Take& take) {
    const Floats d;
    const Piece whole(front, back);
    if (hn::AllTrue(d, hn::Le(whole.depth, hn::Zero(d)))) return;
    const auto shadeAt = [&](V way) HWY_ATTR {
        const GridPlace place(source.samples(), rays, way);
        const FieldCell cell(source, place);
        return CellLight(cell).shadeAt(way);
    };
    take(LitPiece(shadeAt, whole, front, back, length));
}

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
