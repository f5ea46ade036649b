// SPDX-License-Identifier: GPL-3.0-or-later
//
// GridSource: what is read of one field of samples, a vector at a time: the coarse grid where nothing is
// corrected, a brick's own samples where it is (docs/PICTURE.md). Compiled once for each target (Highway's
// foreach_target), hence without #pragma once.
#if defined(MOTE_GRID_SOURCE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_GRID_SOURCE_INL_H
#undef MOTE_GRID_SOURCE_INL_H
#else
#define MOTE_GRID_SOURCE_INL_H
#endif

#include "server/render/cpu/composite/light-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// A grid of samples, their normals and, if they are asked for, their slopes; of bricks, which lie one after
/// the other, all of them.
struct GridReads {
    const std::uint8_t* values;
    const std::uint8_t* normals;
    const std::uint8_t* slopes;
    std::size_t row, sheet;  ///< samples to the next row and sheet; 0 where there is none
    bool single;             ///< there is none to the next sample along x

    HWY_INLINE GridReads(const SampleGrid& grid, const GridSlopes* steep)
        : values(reinterpret_cast<const std::uint8_t*>(grid.values.data())),
          normals(grid.normals.data()),
          slopes(steep != nullptr ? steep->coarse.data() : nullptr),
          row(grid.size.y > 1 ? grid.size.x : 0),
          sheet(grid.size.z > 1 ? std::size_t{grid.size.x} * grid.size.y : 0),
          single(grid.size.x == 1) {}
    HWY_INLINE GridReads(const GridBricks& bricks, const GridSlopes* steep)
        : values(reinterpret_cast<const std::uint8_t*>(bricks.values.data())),
          normals(bricks.normals.data()),
          slopes(steep != nullptr ? steep->bricks.data() : nullptr),
          row(GridBricks::samples),
          sheet(std::size_t{GridBricks::samples} * GridBricks::samples),
          single(false) {}
};

/// t as the TransferTable counts it, to the nearest 256th: what is constant and lies right on a step of a
/// curve is then on the same side of it by all kinds of vectors.
HWY_INLINE V snapped(V density) {
    const V large = hn::Set(Floats(), 49152.0F);
    return hn::Sub(hn::Add(density, large), large);
}

/// The first samples of cells of the error grid, each in the brick that it lies in.
struct BrickCell {
    hn::Mask<Floats> corrected;
    IntV index;  ///< of the first sample

    HWY_INLINE BrickCell(const GridBricks& bricks, IntV x, IntV y, IntV z) {
        const Ints ints;
        const IntV across = hn::Set(ints, static_cast<std::int32_t>(bricks.count.x));
        const IntV down = hn::Set(ints, static_cast<std::int32_t>(bricks.count.y));
        const IntV row = hn::Add(hn::Mul(hn::ShiftRight<3>(z), down), hn::ShiftRight<3>(y));
        const IntV at = hn::Add(hn::Mul(row, across), hn::ShiftRight<3>(x));
        const IntV number = hn::GatherIndex(ints, bricks.numbers.data(), at);
        corrected = hn::RebindMask(Floats(), hn::Gt(number, hn::Set(ints, -1)));
        index = indexOf(number, x, y, z);
    }
    /// Of a brick by its number; of none of the first.
    HWY_INLINE static IntV indexOf(IntV number, IntV x, IntV y, IntV z) {
        const Ints ints;
        const IntV seven = hn::Set(ints, 7), nine = hn::Set(ints, 9);
        const IntV inRow = hn::Add(hn::Mul(hn::And(z, seven), nine), hn::And(y, seven));
        const IntV inside = hn::Add(hn::Mul(inRow, nine), hn::And(x, seven));
        const IntV volume = hn::Set(ints, std::int32_t{GridBricks::volume});
        return hn::Add(hn::Mul(hn::Max(number, hn::Zero(ints)), volume), inside);
    }
};

class GridSource {
  public:
    HWY_INLINE explicit GridSource(const GridSamples& samples)
        : samples_(samples),
          coarse_(*samples.coarse, samples.slopes),
          bricks_(samples.bricks != nullptr ? GridReads(*samples.bricks, samples.slopes) : coarse_) {}

    const GridSamples& samples() const { return samples_; }
    const GridReads& coarse() const { return coarse_; }
    const GridReads& bricks() const { return bricks_; }

    /// The sample at a way where the density is `exact`. Its colour is the transfer function's, without
    /// light.
    HWY_INLINE Sample sampleWith(V way, V exact) const {
        const V density = snapped(exact);
        const Whole whole(held(density));
        return sampleOf(way, density, hn::Sub(density, whole.value),
                        readEntries(samples_.table->entries(), whole.number()));
    }

    /// Whether no density from `low` to `high` has extinction.
    HWY_INLINE hn::Mask<Floats> showsNothing(V low, V high) const {
        const Whole first(held(snapped(low))), last(held(snapped(high)));
        const V next = hn::GatherIndex(Floats(), samples_.table->nextVisible(), first.number());
        return hn::Gt(next, last.value);
    }

    /// The density of a code, as the TransferTable counts it.
    HWY_INLINE V densityOf(V code) const {
        const Floats d;
        return hn::MulAdd(code, hn::Set(d, samples_.places.scale), hn::Set(d, samples_.places.shift));
    }

  private:
    /// The density, or the nearest one within the table.
    HWY_INLINE static V held(V density) {
        const Floats d;
        return hn::Min(hn::Max(density, hn::Set(d, 0.5F)), hn::Set(d, TransferTable::cells + 1.25F));
    }

    const GridSamples& samples_;
    GridReads coarse_, bricks_;
};

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
