// SPDX-License-Identifier: GPL-3.0-or-later
//
// The march of a packet through one field, of densities or of samples, in which nothing else is. Through
// densities, rays go from cell to cell (CellWalk), in each of which the density is smooth: its kinks lie on
// the planes through cell centres. Compiled once for each target (Highway's foreach_target), hence without
// #pragma once. Source: Amanatides and Woo, A fast voxel traversal algorithm for ray tracing (1987).
#if defined(MOTE_FIELD_MARCH_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_FIELD_MARCH_INL_H
#undef MOTE_FIELD_MARCH_INL_H
#else
#define MOTE_FIELD_MARCH_INL_H
#endif

#include <algorithm>
#include <array>
#include <cmath>

#include "server/render/cpu/composite/cubic-inl.h"
#include "server/render/cpu/composite/grid_pieces-inl.h"
#include "server/render/cpu/composite/light-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// A way through a cell, of which the cells around are being read.
struct CellPart {
    V from, to;  ///< ways
    V x, y, z;   ///< of the cell
    CellReads cells;
};

/// The middle and the end of a way through a cell, of which the table is being read.
struct PartReads {
    TableReads middle, back;
};

class CellWalk {
  public:
    /// Walks from a way through the box.
    HWY_INLINE CellWalk(const DensitySource& source, const RayLanes& rays, const PacketRays& packet,
                        std::size_t lane, V from)
        : way_(from) {
        const Floats d;
        const Ints ints;
        const Whole x(hn::MulAdd(from, rays.travelX, rays.entryX));
        const Whole y(hn::MulAdd(from, rays.travelY, rays.entryY));
        const Whole z(hn::MulAdd(from, rays.travelZ, rays.entryZ));
        offset_ = cellOffset(source, x, y, z);
        const auto aim = [&](Axis& axis, V cell, V entry, const Lanes& inverse, std::int32_t bytes) HWY_ATTR {
            axis.cell = cell;
            axis.inverse = hn::LoadU(d, inverse.data() + lane);
            const auto forward = hn::Gt(axis.inverse, hn::Zero(d));
            const V ahead = hn::IfThenElseZero(forward, hn::Set(d, 1.0F));
            axis.start = hn::Mul(hn::Sub(ahead, entry), axis.inverse);
            axis.step = hn::IfThenElse(forward, hn::Set(d, 1.0F), hn::Set(d, -1.0F));
            axis.stride =
                hn::IfThenElse(hn::RebindMask(ints, forward), hn::Set(ints, bytes), hn::Set(ints, -bytes));
        };
        aim(x_, x.value, rays.entryX, packet.inverse[0], 4);
        aim(y_, y.value, rays.entryY, packet.inverse[1], static_cast<std::int32_t>(source.rowBytes));
        aim(z_, z.value, rays.entryZ, packet.inverse[2], static_cast<std::int32_t>(source.sheetBytes));
    }

    /// Reads the cell that the rays are in and leaves it, or goes as far in it as to the way `end`. Rays that
    /// are there stay where they are.
    HWY_INLINE void next(const DensitySource& source, V end, CellPart& part) {
        const V crossX = x_.crossing(), crossY = y_.crossing(), crossZ = z_.crossing();
        const V leave = hn::Max(hn::Min(hn::Min(crossX, crossY), hn::Min(crossZ, end)), way_);
        part.from = way_, part.to = leave;
        part.x = x_.cell, part.y = y_.cell, part.z = z_.cell;
        part.cells = readCells(source, offset_);
        x_.leave(hn::Le(crossX, leave), offset_);
        y_.leave(hn::Le(crossY, leave), offset_);
        z_.leave(hn::Le(crossZ, leave), offset_);
        way_ = leave;
    }

  private:
    struct Axis {
        V cell, inverse, start, step;
        IntV stride;  // bytes

        /// The way at which the plane ahead is reached.
        HWY_INLINE V crossing() const { return hn::MulAdd(cell, inverse, start); }
        HWY_INLINE void leave(hn::Mask<Floats> crossed, IntV& offset) {
            const Ints ints;
            cell = hn::IfThenElse(crossed, hn::Add(cell, step), cell);
            offset = hn::IfThenElse(hn::RebindMask(ints, crossed), hn::Add(offset, stride), offset);
        }
    };

    V way_;
    IntV offset_;
    Axis x_, y_, z_;
};

/// A way that lies within one cell: the one around its middle.
HWY_INLINE CellPart partBetween(const DensitySource& source, const RayLanes& rays, V from, V to) {
    const V middle = hn::Mul(hn::Add(from, to), hn::Set(Floats(), 0.5F));
    const Whole x(hn::MulAdd(middle, rays.travelX, rays.entryX));
    const Whole y(hn::MulAdd(middle, rays.travelY, rays.entryY));
    const Whole z(hn::MulAdd(middle, rays.travelZ, rays.entryZ));
    return {from, to, x.value, y.value, z.value, readCells(source, cellOffset(source, x, y, z))};
}

/// The way at which rays next leave their cell.
HWY_INLINE V nextPlane(const RayLanes& rays, const PacketRays& packet, std::size_t lane, V way) {
    const Floats d;
    const auto crossing = [&](V travel, V entry, const Lanes& inverse) HWY_ATTR {
        const V share = hn::LoadU(d, inverse.data() + lane);
        const auto forward = hn::Gt(share, hn::Zero(d));
        // A plane less than a thousandth of a cell ahead counts as passed, or rounding would find it again.
        const V skip = hn::IfThenElse(forward, hn::Set(d, 1e-3F), hn::Set(d, -1e-3F));
        const V below = Whole(hn::Add(hn::MulAdd(way, travel, entry), skip)).value;
        const V plane = hn::Add(below, hn::IfThenElseZero(forward, hn::Set(d, 1.0F)));
        return hn::Mul(hn::Sub(plane, entry), share);
    };
    return hn::Min(crossing(rays.travelX, rays.entryX, packet.inverse[0]),
                   hn::Min(crossing(rays.travelY, rays.entryY, packet.inverse[1]),
                           crossing(rays.travelZ, rays.entryZ, packet.inverse[2])));
}

/// Densities along rays within the cells of a part.
class PartDensity {
  public:
    HWY_INLINE PartDensity(const RayLanes& rays, const CellPart& part)
        : cells_(part.cells),
          x_(hn::Sub(rays.entryX, part.x)),
          y_(hn::Sub(rays.entryY, part.y)),
          z_(hn::Sub(rays.entryZ, part.z)) {}

    HWY_INLINE TableReads read(const DensitySource& source, const RayLanes& rays, V way) const {
        return readTable(source, way,
                         densityIn(cells_, hn::MulAdd(way, rays.travelX, x_),
                                   hn::MulAdd(way, rays.travelY, y_), hn::MulAdd(way, rays.travelZ, z_)));
    }

  private:
    CellReads cells_;
    V x_, y_, z_;
};

HWY_INLINE PartReads readPart(const DensitySource& source, const RayLanes& rays, const CellPart& part) {
    const PartDensity density(rays, part);
    return {density.read(source, rays, hn::Mul(hn::Add(part.from, part.to), hn::Set(Floats(), 0.5F))),
            density.read(source, rays, part.to)};
}

/// What lies between two samples of a volume, extinction taken as linear.
struct VolumePiece {
    V mean, depth;

    HWY_INLINE VolumePiece(const Sample& from, const Sample& to)
        : mean(hn::Mul(hn::Add(from.slope, to.slope), hn::Set(Floats(), 0.5F))),
          depth(hn::Mul(mean, hn::Sub(to.way, from.way))) {}
};

/// A way through a cell by three samples, as far apart as each other, and what lies between them.
struct CellPieces {
    VolumePiece near, far, whole;
    V halves;  ///< optical depth of both halves, over that of a way of length 1

    HWY_INLINE CellPieces(const Sample& front, const Sample& middle, const Sample& back)
        : near(front, middle),
          far(middle, back),
          whole(front, back),
          halves(hn::Add(near.depth, far.depth)) {}
};

/// Hands to `take(depth, from, to, mean)` what lies between two samples around which the density is smooth:
/// the depths of the halves and of the whole, each with the density taken as linear, are extrapolated
/// (Romberg).
template <class Take>
HWY_INLINE void takeSmooth(const CellPieces& pieces, const Sample& front, const Sample& middle,
                           const Sample& back, const Take& take) {
    const Floats d;
    if (hn::AllTrue(d, hn::Le(pieces.halves, hn::Zero(d)))) return;
    const V change = hn::Mul(hn::Sub(pieces.halves, pieces.whole.depth),
                             reciprocal(hn::Max(pieces.halves, hn::Set(d, 1e-20F))));
    const V scale = hn::Max(hn::MulAdd(change, hn::Set(d, 1.0F / 3.0F), hn::Set(d, 1.0F)), hn::Zero(d));
    take(hn::Mul(pieces.near.depth, scale), front, middle, pieces.near.mean);
    take(hn::Mul(pieces.far.depth, scale), middle, back, pieces.far.mean);
}

/// An optical depth by which halves may differ from the whole where a parabola still tells what lies between,
/// and one of a part whose front hides so much of its back that its colour does not change evenly; what is
/// more is cut into several pieces.
constexpr float bentDepth = 0.02F, deepPart = 1.0F;
/// A change of t, as the TransferTable counts it, over which a colour map does not change evenly.
constexpr float colorfulChange = 0.1F * TransferTable::cells;
/// A part is cut into the fewer pieces where none of these is much exceeded, else into the more.
constexpr float fewPieces = 2.0F, manyPieces = 4.0F, muchMore = 2.0F;

/// The same for the rays whose extinction is steep in a part, each in as many pieces as it needs itself: what
/// its neighbours in the vector need must not show. `steep`: which; `pieces`: how many.
template <class Take>
HWY_INLINE void takeSteep(const DensitySource& source, const RayLanes& rays, const Sample& front,
                          const Sample& back, hn::Mask<Floats> steep, V pieces, const Take& take) {
    const Floats d;
    const float most = hn::GetLane(hn::MaxOfLanes(d, pieces));
    const PartDensity density(rays, partBetween(source, rays, front.way, back.way));
    const V step = hn::Div(hn::Mul(hn::Sub(back.way, front.way), hn::Set(d, 0.5F)), pieces);
    Sample from = front;
    float i = 0.0F;
    while (i < most) {
        const auto counts = hn::And(steep, hn::Lt(hn::Set(d, i), pieces));
        const V way = hn::Min(hn::Add(from.way, step), back.way);
        const TableReads half = density.read(source, rays, way);
        const TableReads end = density.read(source, rays, hn::Min(hn::Add(way, step), back.way));
        const Sample to = sampleOf(end);
        const Sample between = sampleOf(half);
        const VolumePiece near(from, between), far(between, to);
        if (!hn::AllTrue(d, hn::Le(hn::Add(near.depth, far.depth), hn::Zero(d)))) {
            take(hn::IfThenElseZero(counts, near.depth), from, between, near.mean);
            take(hn::IfThenElseZero(counts, far.depth), between, to, far.mean);
        }
        from = to;
        i += 1.0F;
    }
}

/// Rays whose extinction bends much or is deep, or whose colours change much, in a part; and those whose
/// colours do.
struct SteepRays {
    hn::Mask<Floats> all, colorful;
};

/// The same for a part of which the table was read, in several pieces where it is steep. `length`: of a way
/// of 1; `seen`: the rays that see something yet, for whom it matters how.
template <class Take>
HWY_INLINE SteepRays takePart(const DensitySource& source, const RayLanes& rays, const Sample& front,
                              const PartReads& reads, const Sample& back, V length, hn::Mask<Floats> seen,
                              const Take& take) {
    const Floats d;
    const Sample middle = sampleOf(reads.middle);
    const CellPieces pieces(front, middle, back);
    const auto moved = hn::And(seen, hn::Gt(back.way, front.way));
    const V wrong = hn::Mul(hn::Abs(hn::Sub(pieces.halves, pieces.whole.depth)), length);
    const V deep = hn::Mul(pieces.halves, length);
    const auto bent = hn::Gt(wrong, hn::Set(d, bentDepth));
    const V change = hn::Max(hn::Abs(hn::Sub(middle.density, front.density)),
                             hn::Abs(hn::Sub(back.density, middle.density)));
    const auto colorful = hn::And(hn::Gt(deep, hn::Zero(d)), hn::Gt(change, hn::Set(d, colorfulChange)));
    const auto steep = hn::And(moved, hn::Or(hn::Or(bent, colorful), hn::Gt(deep, hn::Set(d, deepPart))));
    const SteepRays rayKinds{steep, hn::And(moved, colorful)};
    if (hn::AllFalse(d, steep)) {
        takeSmooth(pieces, front, middle, back, take);
        return rayKinds;
    }
    takeSmooth(pieces, front, middle, back,
               [&](V depth, const Sample& one, const Sample& other, V mean)
                   HWY_ATTR { take(hn::IfThenZeroElse(steep, depth), one, other, mean); });
    const auto much = hn::Or(hn::Or(hn::Gt(wrong, hn::Set(d, muchMore * bentDepth)),
                                    hn::Gt(deep, hn::Set(d, muchMore * deepPart))),
                             hn::Gt(change, hn::Set(d, muchMore * colorfulChange)));
    const V pieceCount = hn::IfThenElse(hn::And(steep, much), hn::Set(d, manyPieces), hn::Set(d, fewPieces));
    takeSteep(source, rays, front, back, steep, pieceCount, take);
    return rayKinds;
}

/// A part of rays' ways, and what it did to their light.
struct PassedPart {
    Sample front, back;
    V middle;             ///< extinction there
    V length;             ///< of a way of 1
    V depth;              ///< optical
    Light before, after;  ///< the light at its ends
};

/// The light within a part: of little depth the cubic that has the light and its change at both ends
/// (Hermite); of more what is lost and gained by optical depth, extinction taken as a parabola and the colour
/// as even.
class PartLight {
  public:
    static constexpr float deep = 0.5F;  ///< optical depth

    HWY_INLINE explicit PartLight(const PassedPart& part) : part_(part) {
        const Floats d;
        const V tiny = hn::Set(d, 1e-20F);
        const V way = hn::Sub(part.back.way, part.front.way);
        perWay_ = hn::Div(hn::Set(d, 1.0F), hn::Max(way, tiny));
        const V rate = hn::Mul(way, part.length);
        const V first = hn::Mul(hn::Mul(rate, part.front.slope), part.before.left);
        const V last = hn::Mul(hn::Mul(rate, part.back.slope), part.after.left);
        left_ = Cubic::between(part.before.left, part.after.left, hn::Neg(first), hn::Neg(last));
        const V scale = hn::Set(d, colorScale);
        const V firstLight = hn::Mul(first, scale), lastLight = hn::Mul(last, scale);
        const auto gained = [&](V before, V after, V front, V back) HWY_ATTR {
            return Cubic::between(before, after, hn::Mul(firstLight, front), hn::Mul(lastLight, back));
        };
        red_ = gained(part.before.red, part.after.red, part.front.red, part.back.red);
        green_ = gained(part.before.green, part.after.green, part.front.green, part.back.green);
        blue_ = gained(part.before.blue, part.after.blue, part.front.blue, part.back.blue);
    }
    /// At a way of the rays `here`.
    HWY_INLINE Light at(V way, hn::Mask<Floats> here) const {
        const Floats d;
        const V s = held(hn::Mul(hn::Sub(way, part_.front.way), perWay_));
        Light light;
        light.left = left_.at(s), light.red = red_.at(s), light.green = green_.at(s),
        light.blue = blue_.at(s);
        light.left = hn::Min(hn::Max(light.left, part_.after.left), part_.before.left);
        const auto much = hn::And(here, hn::Gt(part_.depth, hn::Set(d, deep)));
        if (hn::AllFalse(d, much)) return light;
        const V share = shareTo(s);
        const auto either = [&](V before, V after, V cubic) HWY_ATTR {
            return hn::IfThenElse(much, hn::MulAdd(share, hn::Sub(after, before), before), cubic);
        };
        light.left = either(part_.before.left, part_.after.left, light.left);
        light.red = either(part_.before.red, part_.after.red, light.red);
        light.green = either(part_.before.green, part_.after.green, light.green);
        light.blue = either(part_.before.blue, part_.after.blue, light.blue);
        return light;
    }

  private:
    HWY_INLINE static V held(V share) {
        const Floats d;
        return hn::Min(hn::Max(share, hn::Zero(d)), hn::Set(d, 1.0F));
    }
    /// What of the loss and gain lies before a share of the way, of deep parts:
    /// (1 - exp(-depth * share)) / (1 - exp(-depth)), share being that of the depth.
    HWY_INLINE V shareTo(V s) const {
        const Floats d;
        const V one = hn::Set(d, 1.0F);
        const V lost = hn::Sub(one, expMinus(hn::Mul(part_.depth, depthTo(s))));
        return hn::Div(lost, hn::Max(hn::Sub(one, expMinus(part_.depth)), hn::Set(d, 0.1F)));
    }
    /// The share of the optical depth that lies before a share of the way.
    HWY_INLINE V depthTo(V s) const {
        const Floats d;
        const V front = part_.front.slope, back = part_.back.slope;
        const V four = hn::Mul(part_.middle, hn::Set(d, 4.0F)), three = hn::Set(d, 3.0F);
        const V total = hn::Max(hn::Add(hn::Add(front, back), four), hn::Set(d, 1e-20F));
        const V square = hn::Mul(hn::Sub(hn::Sub(four, back), hn::Mul(three, front)), three);
        const V cube =
            hn::Mul(hn::Sub(hn::Add(front, back), hn::Add(part_.middle, part_.middle)), hn::Set(d, 4.0F));
        const V sixfold =
            hn::Mul(s, hn::MulAdd(s, hn::MulAdd(s, cube, square), hn::Mul(front, hn::Set(d, 6.0F))));
        return held(hn::Div(sixfold, total));
    }

    const PassedPart& part_;
    V perWay_;
    Cubic left_, red_, green_, blue_;
};

/// Whether the cells that some rays are in let all light through.
HWY_INLINE bool nothingIn(const CellReads& cells) {
    const WordV all = hn::Or(hn::Or(bitsOfAny(cells.frontLow), bitsOfAny(cells.frontHigh)),
                             hn::Or(bitsOfAny(cells.backLow), bitsOfAny(cells.backHigh)));
    const Words words;
    return hn::AllTrue(words, hn::Eq(hn::And(all, hn::Set(words, 0xffff0000U)), hn::Zero(words)));
}

/// Nobody asks for the light on the way.
struct NoBorders {
    HWY_INLINE V mostLeft() const { return hn::Set(Floats(), Light::least); }
    HWY_INLINE void pass(V, const Light&) const {}
    HWY_INLINE void pass(const PassedPart&, const SteepRays&) const {}
};

/// Marches from `front` to a way, cell by cell. Of each part that is gathered `borders.pass` is told, with
/// the light at its back. Returns the sample at the end.
template <class Borders>
HWY_INLINE Sample marchCells(const DensitySource& source, const PacketRays& packet, std::size_t lane,
                             Sample front, V end, Light& light, Borders borders) {
    const Floats d;
    const RayLanes rays(packet, lane);
    const V length = hn::LoadU(d, packet.length.data() + lane);
    CellWalk walk(source, rays, packet, lane, front.way);
    // In place, as copies of so many vectors would take as long as what is reckoned.
    std::array<CellPart, 3> parts;  // the one that is passed, and two of which cells are being read
    std::array<PartReads, 2> reads;
    CellPart *part = &parts[0], *nextPart = &parts[1], *spare = &parts[2];
    PartReads *partReads = &reads[0], *nextReads = &reads[1];
    walk.next(source, end, *part);
    bool clear = nothingIn(part->cells);
    if (!clear) *partReads = readPart(source, rays, *part);
    walk.next(source, end, *nextPart);
    const auto behindPart = [&]() HWY_ATTR {
        return sampleOf(PartDensity(rays, *part).read(source, rays, part->to));
    };
    while (true) {
        walk.next(source, end, *spare);
        const bool nextClear = nothingIn(nextPart->cells);
        if (!nextClear) *nextReads = readPart(source, rays, *nextPart);
        bool gone = false;
        if (clear) {
            front.way = part->to;
            borders.pass(part->to, light);
            if (!nextClear) front = behindPart();
        } else {
            const Sample back = sampleOf(partReads->back);
            const Light before = light;
            V depth = hn::Zero(d);
            const auto steep =
                takePart(source, rays, front, *partReads, back, length, light.seen(),
                         [&](V piece, const Sample& one, const Sample& other, V mean) HWY_ATTR {
                             const V tau = hn::Mul(piece, length);
                             depth = hn::Add(depth, tau);
                             light.gather(tau, one, other, mean);
                         });
            // What neighbours meet where a ray itself meets nothing does not end it.
            gone = light.gone(borders.mostLeft(), hn::Gt(depth, hn::Zero(d)));
            borders.pass({front, back, partReads->middle.extinction, length, depth, before, light}, steep);
            front = back;
        }
        if (gone || hn::AllTrue(d, hn::Ge(front.way, end))) break;
        clear = nextClear;
        std::swap(partReads, nextReads);
        CellPart* const done = part;
        part = nextPart, nextPart = spare, spare = done;
    }
    return clear ? behindPart() : front;
}

/// Marches from `front`, in a slab, to another, by samples at multiples of `segment`. Returns the last one.
HWY_INLINE Sample marchEvenly(const DensitySource& source, const PacketRays& packet, std::size_t lane,
                              Sample front, float from, float to, float segment, Light& light) {
    const Floats d;
    const RayLanes rays(packet, lane);
    const V length = hn::LoadU(d, packet.length.data() + lane);
    const float first = std::floor(from / segment) + 1.0F;
    const auto count = static_cast<std::size_t>(std::max(std::ceil(to / segment) - first, 0.0F)) + 1;
    // In passes over a block of samples: no step of one waits for another sample's, so that many reads of
    // memory are under way at a time.
    constexpr std::size_t block = 16;
    std::array<Place, block> places;
    std::array<Density, block> densities;
    for (std::size_t begin = 0; begin < count; begin += block) {
        const std::size_t size = std::min(block, count - begin);
        for (std::size_t i = 0; i < size; ++i) {
            const float slab = std::min((first + static_cast<float>(begin + i)) * segment, to);
            places[i] = placeAt(source, rays, rays.way(hn::Set(d, slab)));
            prefetchCells(source, places[i]);
        }
        for (std::size_t i = 0; i < size; ++i) densities[i] = densityAt(source, places[i]);
        for (std::size_t i = 0; i < size; ++i) {
            const Sample back = sampleOf(readTable(source, places[i].way, densities[i]));
            const VolumePiece piece(front, back);
            if (!hn::AllTrue(d, hn::Le(piece.depth, hn::Zero(d)))) {
                light.gather(hn::Mul(piece.depth, length), front, back, piece.mean);
                if (light.gone()) return back;
            }
            front = back;
        }
    }
    return front;
}

/// Marches from `front`, in a slab, to another, through a field of samples cell by cell. Returns a sample
/// there.
HWY_INLINE Sample marchGridCells(const GridSource& source, const PacketRays& packet, std::size_t lane,
                                 const Sample& front, float to, Light& light) {
    const RayLanes rays(packet, lane);
    const V length = hn::LoadU(Floats(), packet.length.data() + lane);
    return takeCells(
        source, axesOf(rays, packet, lane), front, rays.way(hn::Set(Floats(), to)), length,
        [&]() HWY_ATTR {
            light.gone();
            return light.seen();
        },
        LightSums{light});
}

/// Marches from `front`, in a slab, to another, through a field of samples by samples at multiples of
/// `segment`. Returns the last one.
HWY_INLINE Sample marchGridEvenly(const GridSource& source, const PacketRays& packet, std::size_t lane,
                                  Sample front, float from, float to, float segment, Light& light) {
    const Floats d;
    const RayLanes rays(packet, lane);
    const ThreeAxes axes = axesOf(rays, packet, lane);
    const V length = hn::LoadU(d, packet.length.data() + lane);
    const float first = std::floor(from / segment) + 1.0F;
    const auto count = static_cast<int>(std::ceil(to / segment) - first) + 1;
    for (int i = 0; i < count; ++i) {
        const float place = std::min((first + static_cast<float>(i)) * segment, to);
        const V way = rays.way(hn::Set(d, place));
        const Sample back = sampleAt(source, axes, way);
        takeEvenly(source, axes, front, back, length, LightSums{light});
        front = back;
        if (light.gone()) break;
    }
    return front;
}

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
