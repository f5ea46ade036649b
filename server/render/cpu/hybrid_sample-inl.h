// SPDX-License-Identifier: GPL-3.0-or-later
//
// Samples of a hybrid volume along the rays of a packet, a vector at a time: the low volume where nothing is
// corrected, a brick's own samples where it is (docs/PICTURE.md). Compiled once for each target (Highway's
// foreach_target), hence without #pragma once.
#if defined(MOTE_HYBRID_SAMPLE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_HYBRID_SAMPLE_INL_H
#undef MOTE_HYBRID_SAMPLE_INL_H
#else
#define MOTE_HYBRID_SAMPLE_INL_H
#endif

#include "server/render/cpu/light-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// A grid of samples and the lights of their normals; of bricks, which lie one after the other, all of them.
struct HybridSamples {
    const std::uint8_t* values;
    const std::uint8_t* normals;
    std::size_t row, sheet;  ///< samples to the next row and sheet; 0 where there is none

    HWY_INLINE explicit HybridSamples(const HybridGrid& grid)
        : values(reinterpret_cast<const std::uint8_t*>(grid.values.data())),
          normals(grid.normals.data()),
          row(grid.size.y > 1 ? grid.size.x : 0),
          sheet(grid.size.z > 1 ? std::size_t{grid.size.x} * grid.size.y : 0) {}
    HWY_INLINE explicit HybridSamples(const HybridBricks& bricks)
        : values(reinterpret_cast<const std::uint8_t*>(bricks.values.data())),
          normals(bricks.normals.data()),
          row(HybridBricks::samples),
          sheet(std::size_t{HybridBricks::samples} * HybridBricks::samples) {}
};

/// Along one axis: the cell that a place is in, and how far.
struct AxisCell {
    IntV cell;
    V share;

    /// `size`: samples; places beyond the outermost are theirs.
    HWY_INLINE AxisCell(V place, std::uint32_t size) {
        const Floats d;
        const Ints ints;
        const V last = hn::Set(d, static_cast<float>(size - 1));
        const V held = hn::Min(hn::Max(place, hn::Zero(d)), last);
        const auto lastCell = static_cast<std::int32_t>(size > 1 ? size - 2 : 0);
        cell = hn::Min(hn::ConvertTo(ints, held), hn::Set(ints, lastCell));
        share = hn::Sub(held, hn::ConvertTo(d, cell));
    }
    /// Half way between two samples their weights change so much faster.
    HWY_INLINE void steepen(float steepness) {
        const Floats d;
        const V half = hn::Set(d, 0.5F);
        const V steep = hn::MulAdd(hn::Sub(share, half), hn::Set(d, steepness), half);
        share = hn::Min(hn::Max(steep, hn::Zero(d)), hn::Set(d, 1.0F));
    }
};

/// Where the eight samples around a place are, and how they weigh.
struct SamplePlace {
    IntV index;     ///< of the first
    WordV weights;  ///< along x
    V shareY, shareZ;

    HWY_INLINE SamplePlace(IntV first, V shareX, V y, V z)
        : index(first), weights(weightsOf(shareX)), shareY(y), shareZ(z) {}
    /// Of what was found along x: in the first row, the next one, and those two in the next sheet.
    HWY_INLINE V between(V near, V below, V far, V last) const {
        const V front = hn::MulAdd(shareY, hn::Sub(below, near), near);
        const V back = hn::MulAdd(shareY, hn::Sub(last, far), far);
        return hn::MulAdd(shareZ, hn::Sub(back, front), front);
    }
};

/// Of two 16-bit codes in each word, less 32768, the mean by weightsOf(); times fullWeight.
HWY_INLINE V meanOfCodes(WordV codes, WordV weights) {
#if HWY_TARGET == HWY_SCALAR
    const std::uint32_t c = hn::GetLane(codes), w = hn::GetLane(weights);
    return hn::Set(
        Floats(), static_cast<float>((static_cast<int>(c & 0xffffU) - 32768) * static_cast<int>(w & 0xffffU) +
                                     (static_cast<int>(c >> 16) - 32768) * static_cast<int>(w >> 16)));
#else
    return meanOfPair(hn::Xor(codes, hn::Set(Words(), 0x80008000U)), weights);
#endif
}

HWY_INLINE WordV gatherWord(const std::uint8_t* base, IntV bytes) {
#if HWY_TARGET == HWY_SCALAR
    return hn::BitCast(Words(), hn::GatherOffset(Ints(), reinterpret_cast<const std::int32_t*>(base), bytes));
#else
    return loadEach(Words(), base, LaneNumbers(bytes).values.data());
#endif
}

/// t as the VolumeTable counts it, to the nearest 256th: what is constant and lies right on a step of a curve
/// is then on the same side of it by all kinds of vectors.
HWY_INLINE V snapped(V density) {
    const V large = hn::Set(Floats(), 49152.0F);
    return hn::Sub(hn::Add(density, large), large);
}

class HybridSource {
  public:
    HWY_INLINE explicit HybridSource(const HybridLayer& layer)
        : layer_(layer),
          low_(*layer.low),
          bricks_(layer.bricks != nullptr ? HybridSamples(*layer.bricks) : low_) {}

    /// Its colour is the transfer function's, without light.
    HWY_INLINE Sample sampleAt(const RayLanes& rays, V way) const {
        const Places places(*this, rays, way);
        if (!places.anyCorrected) return tableAt(way, codeIn(low_, places.low));
        const V code = codeIn(bricks_, places.brick);
        if (!places.anyLow) return tableAt(way, code);
        return tableAt(way, choose(places, code, codeIn(low_, places.low)));
    }

    /// What light makes of a colour at a place: a factor, and white that is added.
    struct Shade {
        V diffuse, specular;
    };
    HWY_INLINE Shade shadeAt(const RayLanes& rays, V way) const {
        const Places places(*this, rays, way);
        if (!places.anyCorrected) return shadeIn(low_, places.low);
        const Shade shade = shadeIn(bricks_, places.brick);
        if (!places.anyLow) return shade;
        const Shade other = shadeIn(low_, places.low);
        return {choose(places, shade.diffuse, other.diffuse), choose(places, shade.specular, other.specular)};
    }

  private:
    /// A place on the rays, in the grids.
    struct Places {
        SamplePlace low, brick;
        hn::Mask<Floats> corrected;
        bool anyLow, anyCorrected;

        HWY_INLINE Places(const HybridSource& source, const RayLanes& rays, V way)
            : low(hn::Zero(Ints()), way, way, way), brick(low), corrected(hn::FirstN(Floats(), 0)) {
            const Floats d;
            const V x = hn::MulAdd(way, rays.travelX, rays.entryX);
            const V y = hn::MulAdd(way, rays.travelY, rays.entryY);
            const V z = hn::MulAdd(way, rays.travelZ, rays.entryZ);
            anyCorrected = false;
            if (source.layer_.bricks != nullptr) setBrick(source.layer_, x, y, z);
            anyLow = source.layer_.correction < 1.0F || !hn::AllTrue(d, corrected);
            if (anyLow) setLow(source.layer_, x, y, z);
        }
        HWY_INLINE void setBrick(const HybridLayer& layer, V x, V y, V z) {
            const Floats d;
            const Ints ints;
            const HybridBricks& bricks = *layer.bricks;
            AxisCell cx(x, bricks.size.x), cy(y, bricks.size.y), cz(z, bricks.size.z);
            if (layer.steepness != 1.0F) {
                for (AxisCell* const axis : {&cx, &cy, &cz}) axis->steepen(layer.steepness);
            }
            const IntV across = hn::Set(ints, static_cast<std::int32_t>(bricks.count.x));
            const IntV down = hn::Set(ints, static_cast<std::int32_t>(bricks.count.y));
            const IntV at = hn::Add(
                hn::Mul(hn::Add(hn::Mul(hn::ShiftRight<3>(cz.cell), down), hn::ShiftRight<3>(cy.cell)),
                        across),
                hn::ShiftRight<3>(cx.cell));
            const IntV number = hn::GatherIndex(ints, bricks.numbers.data(), at);
            corrected = hn::RebindMask(d, hn::Gt(number, hn::Set(ints, -1)));
            anyCorrected = !hn::AllFalse(d, corrected);
            const IntV seven = hn::Set(ints, 7), nine = hn::Set(ints, 9);
            const IntV inside = hn::Add(
                hn::Mul(hn::Add(hn::Mul(hn::And(cz.cell, seven), nine), hn::And(cy.cell, seven)), nine),
                hn::And(cx.cell, seven));
            const IntV begin =
                hn::Mul(hn::Max(number, hn::Zero(ints)), hn::Set(ints, std::int32_t{HybridBricks::volume}));
            brick = SamplePlace(hn::Add(begin, inside), cx.share, cy.share, cz.share);
        }
        HWY_INLINE void setLow(const HybridLayer& layer, V x, V y, V z) {
            const Floats d;
            const Ints ints;
            const glm::uvec3& size = layer.low->size;
            const auto cellOf = [&](V place, int axis) HWY_ATTR {
                return AxisCell(
                    hn::MulAdd(place, hn::Set(d, layer.lowScale[axis]), hn::Set(d, layer.lowShift[axis])),
                    size[axis]);
            };
            const AxisCell cx = cellOf(x, 0), cy = cellOf(y, 1), cz = cellOf(z, 2);
            const IntV across = hn::Set(ints, static_cast<std::int32_t>(size.x));
            const IntV down = hn::Set(ints, static_cast<std::int32_t>(size.y));
            low = SamplePlace(hn::Add(hn::Mul(hn::Add(hn::Mul(cz.cell, down), cy.cell), across), cx.cell),
                              cx.share, cy.share, cz.share);
        }
    };

    /// Where a brick is corrected, so much of that as shows.
    HWY_INLINE V choose(const Places& places, V brick, V low) const {
        const bool whole = layer_.correction >= 1.0F;
        const V shown =
            whole ? brick : hn::MulAdd(hn::Sub(brick, low), hn::Set(Floats(), layer_.correction), low);
        return hn::IfThenElse(places.corrected, shown, low);
    }

    /// As meanOfCodes gives it.
    HWY_INLINE static V codeIn(const HybridSamples& samples, const SamplePlace& place) {
        const IntV bytes = hn::Add(place.index, place.index);
        const auto row = [&](std::size_t ahead) HWY_ATTR {
            return meanOfCodes(gatherWord(samples.values + 2 * ahead, bytes), place.weights);
        };
        return place.between(row(0), row(samples.row), row(samples.sheet), row(samples.sheet + samples.row));
    }

    HWY_INLINE Shade shadeIn(const HybridSamples& samples, const SamplePlace& place) const {
        const Words words;
        const WordV byte = hn::Set(words, 255U), low = hn::Set(words, 0xffffU);
        const auto* const shades = reinterpret_cast<const std::int32_t*>(layer_.shades.data());
        const auto shade = [&](WordV code) HWY_ATTR {
            return hn::BitCast(words,
                               hn::GatherIndex(Ints(), shades, hn::BitCast(Ints(), hn::And(code, byte))));
        };
        const auto row = [&](std::size_t ahead) HWY_ATTR {
            const WordV codes = gatherWord(samples.normals + ahead, place.index);
            const WordV one = shade(codes), other = shade(hn::ShiftRight<8>(codes));
            return Shade{meanOfPair(hn::Or(hn::And(one, low), hn::ShiftLeft<16>(other)), place.weights),
                         meanOfPair(hn::Or(hn::ShiftRight<16>(one), hn::AndNot(low, other)), place.weights)};
        };
        const Shade near = row(0), below = row(samples.row);
        const Shade far = row(samples.sheet), last = row(samples.sheet + samples.row);
        const V one = hn::Set(Floats(), 1.0F / (HybridLayer::fullShade * float{fullWeight}));
        return {hn::Mul(one, place.between(near.diffuse, below.diffuse, far.diffuse, last.diffuse)),
                hn::Mul(one, place.between(near.specular, below.specular, far.specular, last.specular))};
    }

    /// `code`: as meanOfCodes gives it.
    HWY_INLINE Sample tableAt(V way, V code) const {
        const Floats d;
        const Ints ints;
        const float scale = layer_.tableScale;
        const V density = snapped(hn::MulAdd(code, hn::Set(d, scale / float{fullWeight}),
                                             hn::Set(d, 32768.0F * scale + layer_.tableShift)));
        const V held = hn::Min(hn::Max(density, hn::Set(d, 0.5F)), hn::Set(d, VolumeTable::cells + 1.25F));
        const Whole whole(held);
        const IntV cell = hn::BitCast(ints, hn::Sub(whole.word, hn::Set(Words(), Whole::bias)));
        return sampleOf(
            {way, density, hn::Sub(density, whole.value), readEntries(layer_.table->entries(), cell)});
    }

    const HybridLayer& layer_;
    HybridSamples low_, bricks_;
};

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
