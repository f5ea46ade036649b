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

#include "server/render/cpu/composite/lit_path-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// So much may a density's change differ from an even one, as the table counts it.
constexpr float bentDensity = 0.0025F * TransferTable::cells;

/// The density along rays through a cell, in s from 0 at the front to 1 at the back of the way.
struct CellPath {
    const Sample &front, &back;
    V way;
    Cubic density;

    /// `y1`, `y2`: the density at both thirds. `even`: the rays along which it is taken as linear, whatever
    /// these say: a cubic through a kink would leave the range of the cell's corners.
    HWY_INLINE CellPath(const Sample& first, V y1, V y2, const Sample& last, hn::Mask<Floats> even)
        : front(first),
          back(last),
          way(hn::Sub(back.way, front.way)),
          density(Cubic::through(front.density, y1, y2, back.density)) {
        density.c3 = hn::IfThenZeroElse(even, density.c3);
        density.c2 = hn::IfThenZeroElse(even, density.c2);
        density.c1 = hn::IfThenElse(even, hn::Sub(back.density, front.density), density.c1);
    }
    HWY_INLINE V wayAt(V s) const { return hn::MulAdd(s, way, front.way); }
};

/// Where to cut a way through a cell, as shares of it: between cuts the density only rises or only falls, so
/// that no sheet is passed by. What bends without that is cut in the middle.
struct MonotoneCuts {
    V first, second;  ///< 1 where there is none
    hn::Mask<Floats> once, twice;

    HWY_INLINE explicit MonotoneCuts(const CellPath& path) {
        const Floats d;
        const V zero = hn::Zero(d), one = hn::Set(d, 1.0F);
        once = hn::Gt(hn::Add(hn::Abs(path.density.c2), hn::Abs(path.density.c3)), hn::Set(d, bentDensity));
        twice = hn::FirstN(d, 0);
        first = second = one;
        if (hn::AllFalse(d, once)) return;
        // The derivative is c1 + 2 c2 s + 3 c3 s^2.
        const V three = hn::Mul(path.density.c3, hn::Set(d, 3.0F));
        const V square = hn::Sub(hn::Mul(path.density.c2, path.density.c2), hn::Mul(three, path.density.c1));
        const V root = hn::Sqrt(hn::Max(square, zero));
        const V far = hn::Neg(hn::Add(path.density.c2, hn::CopySign(root, path.density.c2)));
        const auto counts = [&](V s) HWY_ATTR {
            return hn::And(hn::And(once, hn::Ge(square, zero)), hn::And(hn::Gt(s, zero), hn::Lt(s, one)));
        };
        const V s = hn::Div(far, three), t = hn::Div(path.density.c1, far);
        const auto atS = counts(s), atT = counts(t);
        twice = hn::And(atS, atT);
        first = hn::IfThenElse(atS, s, hn::IfThenElse(atT, t, hn::Set(d, 0.5F)));
        first = hn::IfThenElse(once, hn::IfThenElse(twice, hn::Min(s, t), first), one);
        second = hn::IfThenElse(twice, hn::Max(s, t), one);
    }
};

/// A path in the light of its cell. `length`: of a way of 1.
HWY_INLINE LitPath litPath(const GridSource& source, const CellPath& path, const CellLight& light, V length) {
    const V third = hn::Mul(path.way, hn::Set(Floats(), 1.0F / 3.0F));
    const Shade front = light.shadeAt(path.front.way), near = light.shadeAt(hn::Add(path.front.way, third)),
                far = light.shadeAt(hn::Sub(path.back.way, third)), back = light.shadeAt(path.back.way);
    const auto along = [&](V Shade::*part) HWY_ATTR {
        return Cubic::through(front.*part, near.*part, far.*part, back.*part);
    };
    LitPath lit{source,
                path.density,
                along(&Shade::diffuse),
                along(&Shade::specular),
                along(&Shade::share),
                path.front,
                hn::Mul(path.way, length)};
    lit.front.way = hn::Zero(Floats());
    return lit;
}

/// Adds to `sums` what rays meet on a path in a cell. `light`: the cell's, once it is needed.
template <class Sums>
HWY_INLINE void takePath(const FieldCell& cell, const CellPath& path, V length, hn::Mask<Floats> lit,
                         CellLight& light, const Sums& sums) {
    const Floats d;
    const GridSource& source = cell.source();
    const V zero = hn::Zero(d), one = hn::Set(d, 1.0F);
    const MonotoneCuts cuts(path);
    PieceSpans spans;
    V seen = zero;
    const auto cut = [&](V from, V to, const Sample& first, const Sample& last,
                         hn::Mask<Floats> there) HWY_ATTR {
        const Piece whole(first, last);
        seen = hn::Add(seen, whole.depth);
        spans.add(from, to, hn::IfThenElseZero(there, pieceCount(piecesWanted(whole, first, last, length))));
    };
    const auto sampleAt = [&](hn::Mask<Floats> which, V s) HWY_ATTR {
        return choose(which, source.sampleWith(path.wayAt(s), path.density.at(s)), path.back);
    };
    const bool once = !hn::AllFalse(d, cuts.once), twice = !hn::AllFalse(d, cuts.twice);
    const Sample first = once ? sampleAt(cuts.once, cuts.first) : path.back;
    cut(zero, cuts.first, path.front, first, lit);
    if (once) {
        const Sample second = twice ? sampleAt(cuts.twice, cuts.second) : path.back;
        cut(cuts.first, cuts.second, first, second, cuts.once);
        if (twice) cut(cuts.second, one, second, path.back, cuts.twice);
    }
    const auto shown = hn::And(lit, hn::Gt(seen, zero));
    if (hn::AllFalse(d, shown)) return;
    light.readOnce(cell);
    sums.take(sumPieces<Sums>(litPath(source, path, light, length), spans, shown));
}

/// The same of what rays meet in a cell from a sample to a way, path by path. Returns a sample there.
/// `even`: the rays to which its density does not change much; only `lit` ones meet something.
template <class Sums>
HWY_INLINE Sample takeCell(const FieldCell& cell, const ThreeAxes& rays, Sample front, V end, V length,
                           hn::Mask<Floats> lit, hn::Mask<Floats> even, const Sums& sums) {
    const Floats d;
    CellLight light;
    do {
        // However close the kinks, each step must go on in single precision.
        const V smooth = hn::Max(cell.smoothFrom(rays, front.way), hn::Add(front.way, hn::Set(d, 1e-7F)));
        const V next = hn::Min(hn::IfThenElse(lit, smooth, end), end);
        const V third = hn::Mul(hn::Sub(next, front.way), hn::Set(d, 1.0F / 3.0F));
        const V y1 = cell.densityAt(hn::Add(front.way, third)), y2 = cell.densityAt(hn::Sub(next, third));
        const Sample back = cell.sampleAt(next);
        takePath(cell, CellPath(front, y1, y2, back, even), length, lit, light, sums);
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
/// What a ray meets, but for rounding, and the slope at its end do not depend on its neighbours in the
/// vector.
template <class Seen, class Sums>
HWY_INLINE Sample takeCells(const GridSource& source, const ThreeAxes& rays, const Sample& from, V end,
                            V length, const Seen& seen, const Sums& sums) {
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
        front = takeCell(cell, rays, front, leave, length, lit, even, sums);
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
template <class Sums>
HWY_INLINE void takeEvenly(const GridSource& source, const ThreeAxes& rays, const Sample& front,
                           const Sample& back, V length, const Sums& sums) {
    const Floats d;
    const Piece whole(front, back);
    if (hn::AllTrue(d, hn::Le(whole.depth, hn::Zero(d)))) return;
    const auto shadeAt = [&](V way) HWY_ATTR {
        const GridPlace place(source.samples(), rays, way);
        const FieldCell cell(source, place);
        return CellLight(cell).shadeAt(way);
    };
    sums.take(LitPiece(shadeAt, whole, front, back, length));
}

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
