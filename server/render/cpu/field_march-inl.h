// SPDX-License-Identifier: GPL-3.0-or-later
//
// The march of a packet through one field, of densities or of samples, in which nothing else is. Compiled
// once for each target (Highway's foreach_target), hence without #pragma once.
#if defined(MOTE_FIELD_MARCH_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_FIELD_MARCH_INL_H
#undef MOTE_FIELD_MARCH_INL_H
#else
#define MOTE_FIELD_MARCH_INL_H
#endif

#include <algorithm>
#include <array>
#include <cmath>

#include "server/render/cpu/cell_walk-inl.h"
#include "server/render/cpu/grid_pieces-inl.h"
#include "server/render/cpu/light-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Marches from `front` to a slab, cell by cell. Returns the sample there.
HWY_INLINE Sample marchCells(const DensitySource& source, const PacketRays& packet, std::size_t lane,
                             Sample front, float to, Light& light) {
    const Floats d;
    const RayLanes rays(packet, lane);
    const V length = hn::LoadU(d, packet.length.data() + lane);
    const V end = rays.way(hn::Set(d, to));
    CellWalk walk(source, rays, packet, lane, front.way, end);
    PartReads reads = readPart(source, rays, walk.next(source));
    CellPart part = walk.next(source);
    while (true) {
        const CellPart nextPart = walk.next(source);
        const PartReads nextReads = readPart(source, rays, part);
        const Sample back = sampleOf(reads.back);
        takePart(source, rays, front, reads, back, length,
                 [&](V depth, const Sample& one, const Sample& other, V mean)
                     HWY_ATTR { light.gather(hn::Mul(depth, length), one, other, mean); });
        if (light.gone()) break;
        front = back;
        if (hn::AllTrue(d, hn::Ge(front.way, end))) break;
        reads = nextReads;
        part = nextPart;
    }
    return front;
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
    std::array<V, block> densities;
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
            const Piece piece(front, back);
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
        [&](const LitPiece& piece)
            HWY_ATTR { light.gather(hn::Mul(piece.depth, length), piece.red, piece.green, piece.blue); });
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
        takeEvenly(source, axes, front, back, length, [&](const LitPiece& piece) HWY_ATTR {
            light.gather(hn::Mul(piece.depth, length), piece.red, piece.green, piece.blue);
        });
        front = back;
        if (light.gone()) break;
    }
    return front;
}

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
