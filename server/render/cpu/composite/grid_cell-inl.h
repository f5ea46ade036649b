// SPDX-License-Identifier: GPL-3.0-or-later
//
// FieldCell: a cell of a field of samples that rays go through, each its own: of a corrected brick, or of the
// coarse grid within one brick. Its corners are read once, and then any number of places in it are sampled.
// Compiled once for each target (Highway's foreach_target), hence without #pragma once.
#if defined(MOTE_GRID_CELL_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_GRID_CELL_INL_H
#undef MOTE_GRID_CELL_INL_H
#else
#define MOTE_GRID_CELL_INL_H
#endif

#include <array>

#include "server/render/cpu/composite/dark_steps-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// What stands at a cell's corners, x fastest.
using Corners = std::array<V, 8>;

/// The number in the low and in the high 16 bits of a word.
HWY_INLINE V lowHalf(WordV word) {
    return hn::ConvertTo(Floats(), hn::BitCast(Ints(), hn::And(word, hn::Set(Words(), 0xffffU))));
}
HWY_INLINE V highHalf(WordV word) {
    return hn::ConvertTo(Floats(), hn::BitCast(Ints(), hn::ShiftRight<16>(word)));
}

HWY_INLINE V least(const Corners& c) {
    return hn::Min(hn::Min(hn::Min(c[0], c[1]), hn::Min(c[2], c[3])),
                   hn::Min(hn::Min(c[4], c[5]), hn::Min(c[6], c[7])));
}
HWY_INLINE V greatest(const Corners& c) {
    return hn::Max(hn::Max(hn::Max(c[0], c[1]), hn::Max(c[2], c[3])),
                   hn::Max(hn::Max(c[4], c[5]), hn::Max(c[6], c[7])));
}

/// The cell that rays come to along one axis of a grid.
struct AxisCell {
    V origin, speed;  ///< how far they are in it: origin + way * speed
    V leave;          ///< way
    IntV cell;        ///< beyond the outermost samples: the last one

    /// `scale` times a place in the space's cells, plus `shift`, is one in the grid's. `size`: its samples.
    HWY_INLINE AxisCell(const AxisRays& rays, V way, float scale, float shift, std::uint32_t size) {
        const Floats d;
        const V entry = hn::MulAdd(rays.entry, hn::Set(d, scale), hn::Set(d, shift));
        speed = hn::Mul(rays.travel, hn::Set(d, scale));
        const auto forward = hn::Gt(rays.inverse, hn::Zero(d));
        // A plane less than a thousandth of a cell ahead counts as passed, or rounding would find it again.
        const V skip = hn::IfThenElse(forward, hn::Set(d, 1e-3F), hn::Set(d, -1e-3F));
        const V below = hn::Floor(hn::Add(hn::MulAdd(way, speed, entry), skip));
        const V plane = hn::Add(below, hn::IfThenElseZero(forward, hn::Set(d, 1.0F)));
        leave = hn::Mul(hn::Sub(plane, entry), hn::Mul(rays.inverse, hn::Set(d, 1.0F / scale)));
        const auto last = static_cast<float>(size > 1 ? size - 2 : 0);
        const V first = hn::Min(hn::Max(below, hn::Zero(d)), hn::Set(d, last));
        origin = hn::Sub(entry, first);
        cell = truncated(d, first);
    }
};

/// How far rays are in a cell, and what is between its corners there.
struct CellShares {
    V x, y, z;

    HWY_INLINE V between(const Corners& c) const {
        const auto mix = [](V share, V one, V other)
                             HWY_ATTR { return hn::MulAdd(share, hn::Sub(other, one), one); };
        const V front = mix(y, mix(x, c[0], c[1]), mix(x, c[2], c[3]));
        const V back = mix(y, mix(x, c[4], c[5]), mix(x, c[6], c[7]));
        return mix(z, front, back);
    }
};

/// A cell in a grid.
struct GridCell {
    V originX, originY, originZ, speedX, speedY, speedZ;  ///< as AxisCell's
    IntV index;                                           ///< of its first sample

    HWY_INLINE GridCell() = default;
    /// A brick's, its cells as long as those that rays are told by.
    HWY_INLINE GridCell(const ThreeAxes& rays, const LitCells& cells, IntV first)
        : originX(hn::Sub(rays[0].entry, hn::ConvertTo(Floats(), cells.x.cell))),
          originY(hn::Sub(rays[1].entry, hn::ConvertTo(Floats(), cells.y.cell))),
          originZ(hn::Sub(rays[2].entry, hn::ConvertTo(Floats(), cells.z.cell))),
          speedX(rays[0].travel),
          speedY(rays[1].travel),
          speedZ(rays[2].travel),
          index(first) {}
    HWY_INLINE GridCell(const AxisCell& x, const AxisCell& y, const AxisCell& z, IntV first)
        : originX(x.origin),
          originY(y.origin),
          originZ(z.origin),
          speedX(x.speed),
          speedY(y.speed),
          speedZ(z.speed),
          index(first) {}
    /// The one or the other, by ray.
    HWY_INLINE GridCell(hn::Mask<Floats> first, const GridCell& one, const GridCell& other)
        : originX(hn::IfThenElse(first, one.originX, other.originX)),
          originY(hn::IfThenElse(first, one.originY, other.originY)),
          originZ(hn::IfThenElse(first, one.originZ, other.originZ)),
          speedX(hn::IfThenElse(first, one.speedX, other.speedX)),
          speedY(hn::IfThenElse(first, one.speedY, other.speedY)),
          speedZ(hn::IfThenElse(first, one.speedZ, other.speedZ)),
          index(other.index) {}
    HWY_INLINE CellShares shares(V way) const {
        const Floats d;
        const auto held = [&](V origin, V speed) HWY_ATTR {
            return hn::Min(hn::Max(hn::MulAdd(way, speed, origin), hn::Zero(d)), hn::Set(d, 1.0F));
        };
        return {held(originX, speedX), held(originY, speedY), held(originZ, speedZ)};
    }
};

inline V leastLeave(const AxisCell& x, const AxisCell& y, const AxisCell& z) {
    return hn::Min(hn::Min(x.leave, y.leave), z.leave);
}

/// The cell that rays come to from a way on, each its own.
struct GridPlace {
    hn::Mask<Floats> corrected;  ///< it is a brick's
    bool any, all;               ///< of them are
    GridCell brick, low, shown;  ///< `low` where that is seen, too
    V leave;                     ///< the way at which rays leave it

    HWY_INLINE GridPlace(const GridSamples& samples, const ThreeAxes& rays, V way) {
        const Floats d;
        corrected = hn::FirstN(d, 0);
        if (samples.bricks != nullptr) findBrick(*samples.bricks, rays, way);
        any = !hn::AllFalse(d, corrected);
        all = hn::AllTrue(d, corrected);
        if (!all || samples.correction < 1.0F) findCoarse(samples, rays, way);
        shown = all ? brick : any ? GridCell(corrected, brick, low) : low;
    }
    /// Of rays that all are in corrected bricks, but for those that do not matter.
    HWY_INLINE GridPlace(const ThreeAxes& rays, const LitCells& cells)
        : corrected(hn::Not(hn::FirstN(Floats(), 0))),
          any(true),
          all(true),
          brick(rays, cells, BrickCell::indexOf(cells.place, cells.x.cell, cells.y.cell, cells.z.cell)),
          low(brick),
          shown(brick) {
        leave = hn::Min(hn::Min(cells.x.leave(rays[0]), cells.y.leave(rays[1])), cells.z.leave(rays[2]));
    }
    /// The brick's or the coarse grid's, by ray.
    HWY_INLINE V chosen(V ofBrick, V ofLow) const { return hn::IfThenElse(corrected, ofBrick, ofLow); }

  private:
    HWY_INLINE void findBrick(const GridBricks& bricks, const ThreeAxes& rays, V way) {
        const AxisCell x(rays[0], way, 1.0F, 0.0F, bricks.size.x), y(rays[1], way, 1.0F, 0.0F, bricks.size.y),
            z(rays[2], way, 1.0F, 0.0F, bricks.size.z);
        const BrickCell cell(bricks, x.cell, y.cell, z.cell);
        corrected = cell.corrected;
        brick = GridCell(x, y, z, cell.index);
        leave = leastLeave(x, y, z);
        if (hn::AllTrue(Floats(), corrected)) return;
        // What is not corrected goes on to the brick's border.
        const auto border = [&](const AxisRays& axis)
                                HWY_ATTR { return AxisCell(axis, way, 1.0F / GridBricks::edge, 0.0F, 1); };
        leave = chosen(leave, leastLeave(border(rays[0]), border(rays[1]), border(rays[2])));
    }
    HWY_INLINE void findCoarse(const GridSamples& samples, const ThreeAxes& rays, V way) {
        const Ints ints;
        const glm::uvec3& size = samples.coarse->size;
        const auto cellOf = [&](int axis) HWY_ATTR {
            return AxisCell(rays[static_cast<std::size_t>(axis)], way, samples.coarseScale[axis],
                            samples.coarseShift[axis], size[axis]);
        };
        const AxisCell x = cellOf(0), y = cellOf(1), z = cellOf(2);
        const IntV across = hn::Set(ints, static_cast<std::int32_t>(size.x));
        const IntV down = hn::Set(ints, static_cast<std::int32_t>(size.y));
        low = GridCell(x, y, z, hn::Add(hn::Mul(hn::Add(hn::Mul(z.cell, down), y.cell), across), x.cell));
        const V own = leastLeave(x, y, z);
        if (samples.bricks == nullptr) {
            leave = own;
        } else {
            leave = samples.correction < 1.0F ? hn::Min(leave, own) : chosen(leave, hn::Min(leave, own));
        }
    }
};

class FieldCell {
  public:
    /// Both must outlive it.
    HWY_INLINE FieldCell(const GridSource& source, const GridPlace& place)
        : source_(source),
          place_(place),
          mixed_(source.samples().correction < 1.0F),
          steep_(source.samples().steepness != 1.0F && place.any) {
        read([](const GridReads& samples, IntV index) HWY_ATTR { return codesAt(samples, index); }, values_);
    }

    const GridSource& source() const { return source_; }

    /// Densities between those of its corners.
    struct Range {
        V low, high;
    };
    HWY_INLINE Range range() const {
        V low = least(values_.shown), high = greatest(values_.shown);
        if (mixed_) {
            low = hn::Min(low, least(values_.low));
            high = hn::Max(high, greatest(values_.low));
        }
        return {source_.densityOf(low), source_.densityOf(high)};
    }

    /// Its colour is the transfer function's, without light.
    HWY_INLINE Sample sampleAt(V way) const { return source_.sampleWith(way, densityAt(way)); }
    /// Its density alone, as the TransferTable counts it.
    HWY_INLINE V densityAt(V way) const { return source_.densityOf(between(values_, Shares(*this, way))); }

    /// So far from a way on the density is smooth, a cubic along each ray: to where weights next begin or end
    /// to change, or to where rays leave.
    HWY_INLINE V smoothFrom(const ThreeAxes& rays, V way) const {
        if (!steep_) return place_.leave;
        const GridCell& cell = place_.shown;
        const V kink = hn::Min(hn::Min(nextKink(cell.originX, rays[0].inverse, way),
                                       nextKink(cell.originY, rays[1].inverse, way)),
                               nextKink(cell.originZ, rays[2].inverse, way));
        return hn::Min(place_.chosen(kink, place_.leave), place_.leave);
    }

  private:
    friend class CellLight;

    /// The corners of what is seen, and of the coarse grid where that shows through.
    struct AllCorners {
        Corners shown, low;
    };
    struct Shares {
        CellShares shown, low;

        HWY_INLINE Shares(const FieldCell& cell, V way) : shown(cell.place_.shown.shares(way)), low(shown) {
            if (cell.mixed_) low = cell.place_.low.shares(way);
            if (!cell.steep_) return;
            for (V* const share : {&shown.x, &shown.y, &shown.z})
                *share = cell.place_.chosen(cell.steepened(*share), *share);
        }
    };

    /// Half way between two samples of a brick their weights change so much faster.
    HWY_INLINE V steepened(V share) const {
        const Floats d;
        const V half = hn::Set(d, 0.5F);
        const V steep = hn::MulAdd(hn::Sub(share, half), hn::Set(d, source_.samples().steepness), half);
        return hn::Min(hn::Max(steep, hn::Zero(d)), hn::Set(d, 1.0F));
    }
    HWY_INLINE V nextKink(V origin, V inverse, V way) const {
        const Floats d;
        const float half = 0.5F / source_.samples().steepness;
        const auto forward = hn::Gt(inverse, hn::Zero(d));
        const V near = hn::Set(d, 0.5F - half), far = hn::Set(d, 0.5F + half);
        const V first = hn::IfThenElse(forward, near, far), second = hn::IfThenElse(forward, far, near);
        const V wayTo = hn::Mul(hn::Sub(first, origin), inverse),
                wayBeyond = hn::Mul(hn::Sub(second, origin), inverse);
        // As with planes, a thousandth of a cell ahead counts as passed.
        const V passed = hn::MulAdd(hn::Abs(inverse), hn::Set(d, 1e-5F), way);
        return hn::IfThenElse(hn::Gt(wayTo, passed), wayTo,
                              hn::IfThenElse(hn::Gt(wayBeyond, passed), wayBeyond, place_.leave));
    }

    HWY_INLINE V between(const AllCorners& corners, const Shares& shares) const {
        const V shown = shares.shown.between(corners.shown);
        if (!mixed_) return shown;
        const V low = shares.low.between(corners.low);
        return hn::MulAdd(hn::Sub(shown, low), hn::Set(Floats(), source_.samples().correction), low);
    }

    /// `cornersAt(samples, index)`: what stands at the corners of a grid's cells.
    template <class CornersAt>
    HWY_INLINE void read(const CornersAt& cornersAt, AllCorners& corners) const {
        if (!place_.any) {
            corners.shown = cornersAt(source_.coarse(), place_.low.index);
            if (mixed_) corners.low = corners.shown;
            return;
        }
        corners.shown = cornersAt(source_.bricks(), place_.brick.index);
        if (place_.all && !mixed_) return;
        corners.low = cornersAt(source_.coarse(), place_.low.index);
        for (std::size_t i = 0; i < 8; ++i)
            corners.shown[i] = place_.chosen(corners.shown[i], corners.low[i]);
    }
    HWY_INLINE static Corners codesAt(const GridReads& samples, IntV index) {
        const IntV bytes = hn::Add(index, index);
        Corners corners;
        for (std::size_t i = 0; i < 4; ++i) {
            const std::size_t ahead = (i & 1U) * samples.row + (i >> 1U) * samples.sheet;
            const WordV pair = gatherWord(samples.values + 2 * ahead, bytes);
            corners[2 * i] = lowHalf(pair);
            corners[2 * i + 1] = samples.single ? corners[2 * i] : highHalf(pair);
        }
        return corners;
    }

    const GridSource& source_;
    const GridPlace& place_;
    bool mixed_;  // the coarse grid shows through what is corrected
    bool steep_;
    AllCorners values_;
};

/// The words of a table by the lowest byte of codes.
HWY_INLINE WordV wordsOf(const std::array<std::uint32_t, 256>& table, WordV codes) {
    const Words d;
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX3
    // From registers: reads of 16 places take longer.
    const auto chosen = [&](std::size_t block) HWY_ATTR {
        const auto* const words = table.data() + 32 * block;
        return WordV{
            _mm512_permutex2var_epi32(hn::LoadU(d, words).raw, codes.raw, hn::LoadU(d, words + 16).raw)};
    };
    const auto bit = [&](std::uint32_t value) HWY_ATTR { return hn::TestBit(codes, hn::Set(d, value)); };
    const auto bit5 = bit(32), bit6 = bit(64), bit7 = bit(128);
    const auto pair = [&](std::size_t block)
                          HWY_ATTR { return hn::IfThenElse(bit5, chosen(block + 1), chosen(block)); };
    const WordV low = hn::IfThenElse(bit6, pair(2), pair(0));
    const WordV high = hn::IfThenElse(bit6, pair(6), pair(4));
    return hn::IfThenElse(bit7, high, low);
#else
    const IntV places = hn::BitCast(Ints(), hn::And(codes, hn::Set(d, 255U)));
    return hn::BitCast(d,
                       hn::GatherIndex(Ints(), reinterpret_cast<const std::int32_t*>(table.data()), places));
#endif
}

/// What light makes of a colour, a factor, and white that is added; and what of the extinction there is.
struct Shade {
    V diffuse, specular, share;
};

class CellLight {
  public:
    HWY_INLINE CellLight() = default;
    HWY_INLINE explicit CellLight(const FieldCell& cell) { readOnce(cell); }
    HWY_INLINE void readOnce(const FieldCell& cell) {
        if (cell_ != nullptr) return;
        cell_ = &cell;
        FieldCell::AllCorners shades;
        cell.read([&](const GridReads& samples, IntV index) HWY_ATTR { return shadesAt(samples, index); },
                  shades);
        split(shades.shown, diffuse_.shown, specular_.shown);
        if (cell.mixed_) split(shades.low, diffuse_.low, specular_.low);
        if (cell.source_.samples().slopes != nullptr) cell.read(slopesAt, slopes_);
    }
    HWY_INLINE Shade shadeAt(V way) const {
        const FieldCell::Shares shares(*cell_, way);
        const V one = hn::Set(Floats(), 1.0F / GridSamples::fullShade);
        return {hn::Mul(one, cell_->between(diffuse_, shares)),
                hn::Mul(one, cell_->between(specular_, shares)), shareAt(shares)};
    }

  private:
    HWY_INLINE V shareAt(const FieldCell::Shares& shares) const {
        const Floats d;
        const GridSamples& samples = cell_->source_.samples();
        if (samples.slopes == nullptr) return hn::Set(d, 1.0F);
        return hn::MulAdd(cell_->between(slopes_, shares), hn::Set(d, samples.gradient / 255.0F),
                          hn::Set(d, 1.0F - samples.gradient));
    }
    HWY_INLINE static Corners slopesAt(const GridReads& samples, IntV index) {
        const auto slope = [](WordV bytes) HWY_ATTR {
            return hn::ConvertTo(Floats(), hn::BitCast(Ints(), hn::And(bytes, hn::Set(Words(), 255U))));
        };
        Corners corners;
        for (std::size_t i = 0; i < 4; ++i) {
            const std::size_t ahead = (i & 1U) * samples.row + (i >> 1U) * samples.sheet;
            const WordV bytes = gatherWord(samples.slopes + ahead, index);
            corners[2 * i] = slope(bytes);
            corners[2 * i + 1] = samples.single ? corners[2 * i] : slope(hn::ShiftRight<8>(bytes));
        }
        return corners;
    }
    /// Words of the field's shades.
    HWY_INLINE Corners shadesAt(const GridReads& samples, IntV index) const {
        const auto& shades = cell_->source_.samples().shades;
        const auto shade = [&](WordV code) HWY_ATTR { return hn::BitCast(Floats(), wordsOf(shades, code)); };
        Corners corners;
        for (std::size_t i = 0; i < 4; ++i) {
            const std::size_t ahead = (i & 1U) * samples.row + (i >> 1U) * samples.sheet;
            const WordV codes = gatherWord(samples.normals + ahead, index);
            corners[2 * i] = shade(codes);
            corners[2 * i + 1] = samples.single ? corners[2 * i] : shade(hn::ShiftRight<8>(codes));
        }
        return corners;
    }
    HWY_INLINE static void split(const Corners& shades, Corners& diffuse, Corners& specular) {
        for (std::size_t i = 0; i < 8; ++i) {
            diffuse[i] = lowHalf(hn::BitCast(Words(), shades[i]));
            specular[i] = highHalf(hn::BitCast(Words(), shades[i]));
        }
    }

    const FieldCell* cell_ = nullptr;
    FieldCell::AllCorners diffuse_, specular_, slopes_;
};

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
