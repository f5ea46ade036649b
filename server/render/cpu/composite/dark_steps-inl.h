// SPDX-License-Identifier: GPL-3.0-or-later
//
// The way of rays past cells of corrected bricks in which nothing shows (DarkCells). Compiled once for each
// target (Highway's foreach_target), hence without #pragma once.
#if defined(MOTE_DARK_STEPS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_DARK_STEPS_INL_H
#undef MOTE_DARK_STEPS_INL_H
#else
#define MOTE_DARK_STEPS_INL_H
#endif

#include <array>

#include "server/render/cpu/composite/grid_source-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Rays along one axis, by their way through the box: their place in the space's cells, and 1 / travel.
struct AxisRays {
    V entry, travel, inverse;
};
using ThreeAxes = std::array<AxisRays, 3>;

HWY_INLINE ThreeAxes axesOf(const RayLanes& rays, const PacketRays& packet, std::size_t lane) {
    const auto inverse = [&](std::size_t axis)
                             HWY_ATTR { return hn::LoadU(Floats(), packet.inverse[axis].data() + lane); };
    return {AxisRays{rays.entryX, rays.travelX, inverse(0)}, AxisRays{rays.entryY, rays.travelY, inverse(1)},
            AxisRays{rays.entryZ, rays.travelZ, inverse(2)}};
}

/// Rays along one axis of the finest grid, and the cells around which nothing shows.
struct DarkAxis {
    IntV below;  ///< the cell that they come to, also beyond the outermost samples
    IntV cell;   ///< the same; beyond the outermost samples the last one

    HWY_INLINE DarkAxis() = default;
    HWY_INLINE DarkAxis(const AxisRays& rays, V way, std::uint32_t size) {
        const Floats d;
        const Ints ints;
        const auto forward = hn::Gt(rays.inverse, hn::Zero(d));
        const V skip = hn::IfThenElse(forward, hn::Set(d, 1e-3F), hn::Set(d, -1e-3F));
        // As in AxisCell.
        const V place = hn::Floor(hn::Add(hn::MulAdd(way, rays.travel, rays.entry), skip));
        below = truncated(d, place);
        cell = hn::Min(hn::Max(below, hn::Zero(ints)),
                       hn::Set(ints, static_cast<std::int32_t>(size > 1 ? size - 2 : 0)));
    }
    /// The way at which they leave the cells up to `steps` away, of the brick, and `beyond` cells around
    /// that.
    HWY_INLINE V leave(const AxisRays& rays, IntV steps, IntV beyond) const {
        const Floats d;
        const Ints ints;
        const IntV seven = hn::Set(ints, 7), one = hn::Set(ints, 1);
        const IntV last = hn::Add(hn::Min(hn::Add(cell, steps), hn::Or(cell, seven)), beyond);
        const IntV first = hn::Sub(hn::Max(hn::Sub(cell, steps), hn::AndNot(seven, cell)), beyond);
        const auto forward = hn::RebindMask(ints, hn::Gt(rays.inverse, hn::Zero(d)));
        const IntV plane = hn::IfThenElse(forward, hn::Add(hn::Max(last, below), one), hn::Min(first, below));
        return hn::Mul(hn::Sub(hn::ConvertTo(d, plane), rays.entry), rays.inverse);
    }
    /// The same of the cell alone, or of what lies beyond the outermost samples.
    HWY_INLINE V leave(const AxisRays& rays) const {
        const Floats d;
        const auto forward = hn::Gt(rays.inverse, hn::Zero(d));
        const V plane = hn::Add(hn::ConvertTo(d, below), hn::IfThenElseZero(forward, hn::Set(d, 1.0F)));
        return hn::Mul(hn::Sub(plane, rays.entry), rays.inverse);
    }
};

/// Rays that have come to what may show wait for the others, so that a vector's are reckoned together, unless
/// they are more than so many times as many.
constexpr std::size_t waitFor = 2;

/// Where rays are that were taken past what shows nothing.
struct LitCells {
    DarkAxis x, y, z;
    IntV place;               ///< DarkCells' of their block
    hn::Mask<Floats> moved;   ///< the rays that were taken on
    hn::Mask<Floats> behind;  ///< of these, the ones that the others do not wait for

    /// Takes rays on to where something may show in their cell; at most to `end`.
    HWY_NOINLINE LitCells(const GridSamples& samples, const ThreeAxes& rays, V end, hn::Mask<Floats> alive,
                          V& way)
        : moved(hn::FirstN(Floats(), 0)), behind(moved) {
        const Floats d;
        const Ints ints;
        const GridBricks& bricks = *samples.bricks;
        const DarkCells& cells = *samples.dark;
        const IntV across = hn::Set(ints, static_cast<std::int32_t>(bricks.count.x));
        const IntV down = hn::Set(ints, static_cast<std::int32_t>(bricks.count.y));
        const IntV seven = hn::Set(ints, 7), one = hn::Set(ints, 1), zero = hn::Zero(ints);
        while (true) {
            x = DarkAxis(rays[0], way, bricks.size.x);
            y = DarkAxis(rays[1], way, bricks.size.y);
            z = DarkAxis(rays[2], way, bricks.size.z);
            const IntV brickRow =
                hn::Add(hn::Mul(hn::ShiftRight<3>(z.cell), down), hn::ShiftRight<3>(y.cell));
            const IntV brick = hn::Add(hn::Mul(brickRow, across), hn::ShiftRight<3>(x.cell));
            place = hn::GatherIndex(ints, cells.places(), brick);
            const IntV inBrick = hn::Add(hn::ShiftLeft<3>(hn::And(z.cell, seven)), hn::And(y.cell, seven));
            const IntV row = hn::Add(hn::ShiftLeft<6>(hn::Max(place, zero)), inBrick);
            const WordV words = hn::BitCast(
                Words(), hn::GatherIndex(ints, reinterpret_cast<const std::int32_t*>(cells.rows()), row));
            const WordV shift = hn::BitCast(Words(), hn::ShiftLeft<2>(hn::And(x.cell, seven)));
            const IntV inRow = hn::BitCast(ints, hn::And(hn::Shr(words, shift), hn::Set(Words(), 15U)));
            const auto asked = hn::Gt(place, hn::Set(ints, -1));
            // Below 0 of what is asked.
            const IntV blocks = hn::Sub(hn::Set(ints, DarkCells::unknown), place);
            const IntV steps = hn::IfThenElse(asked, inRow, blocks);
            const auto dark = hn::And(alive, hn::RebindMask(d, hn::Gt(steps, zero)));
            if (hn::AllFalse(d, dark)) return;
            moved = hn::Or(moved, dark);
            const IntV near = hn::IfThenElse(asked, hn::Sub(inRow, one), seven);
            const IntV beyond = hn::ShiftLeft<3>(hn::Max(hn::Sub(blocks, one), zero));
            const V leave = hn::Min(hn::Min(x.leave(rays[0], near, beyond), y.leave(rays[1], near, beyond)),
                                    z.leave(rays[2], near, beyond));
            // However close the planes, each step must go on in single precision.
            const V next = hn::Min(hn::Max(leave, hn::Add(way, hn::Set(d, 1e-7F))), end);
            way = hn::IfThenElse(dark, next, way);
            if (hn::CountTrue(d, dark) * waitFor < hn::CountTrue(d, hn::AndNot(dark, alive))) {
                behind = dark;
                return;
            }
            alive = hn::And(alive, hn::Lt(way, end));
        }
    }
};

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
