// SPDX-License-Identifier: GPL-3.0-or-later
//
// VolumeSight: what the rays of a packet meet of a volume ahead, by its blocks. Compiled once for each target
// (Highway's foreach_target), hence without #pragma once.
#if defined(MOTE_VOLUME_SIGHT_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_VOLUME_SIGHT_INL_H
#undef MOTE_VOLUME_SIGHT_INL_H
#else
#define MOTE_VOLUME_SIGHT_INL_H
#endif

#include "server/render/cpu/volume_sample-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

struct VolumeSight {
    bool visible = false;  ///< by some ray, or by none
    bool fine = false;     ///< by some ray, in fine steps
    float until = -1.0F;   ///< slab up to which this holds
};

/// From a slab on: as far as all the rays' blocks, with those around them, are alike.
HWY_INLINE VolumeSight lookAhead(const VisibleBlocks& blocks, const PacketRays& rays, std::size_t lane,
                                 float slab, float farthest) {
    const Floats d;
    const Ints ints;

    const RayLanes lanes(rays, lane);
    const V way = lanes.way(hn::Set(d, slab));
    const V x = hn::MulAdd(way, lanes.travelX, lanes.entryX);
    const V y = hn::MulAdd(way, lanes.travelY, lanes.entryY);
    const V z = hn::MulAdd(way, lanes.travelZ, lanes.entryZ);
    const int bits = static_cast<int>(blocks.edgeBits());
    const IntV across = hn::Set(ints, static_cast<std::int32_t>(blocks.count().x));
    const IntV down = hn::Set(ints, static_cast<std::int32_t>(blocks.count().y));
    const IntV blockX = hn::ShiftRightSame(hn::ConvertTo(ints, x), bits);
    const IntV blockY = hn::ShiftRightSame(hn::ConvertTo(ints, y), bits);
    const IntV blockZ = hn::ShiftRightSame(hn::ConvertTo(ints, z), bits);
    const IntV index = hn::Add(hn::Mul(hn::Add(hn::Mul(blockZ, down), blockY), across), blockX);
    const auto* const steps = reinterpret_cast<const std::int32_t*>(blocks.steps());
    const IntV found = hn::And(hn::GatherOffset(ints, steps, index), hn::Set(ints, 255));
    const IntV around = hn::And(found, hn::Set(ints, std::int32_t{VisibleBlocks::farthest}));
    const auto ahead = [&](IntV block, V place, const Lanes& inverse) HWY_ATTR {
        const V edge = hn::Set(d, static_cast<float>(1U << blocks.edgeBits()));
        const V low = hn::ConvertTo(d, hn::Add(hn::Sub(block, around), hn::Set(ints, 1)));
        const V high = hn::ConvertTo(d, hn::Add(block, around));
        const V share = hn::LoadU(d, inverse.data() + lane);
        return hn::Max(hn::Mul(hn::MulSub(low, edge, place), share),
                       hn::Mul(hn::MulSub(high, edge, place), share));
    };
    const V inBlock = hn::Min(ahead(blockX, x, rays.inverse[0]),
                              hn::Min(ahead(blockY, y, rays.inverse[1]), ahead(blockZ, z, rays.inverse[2])));
    const auto inside = hn::Lt(way, hn::Set(d, 1.0F));
    const V leaves = hn::Add(hn::Div(hn::Add(way, inBlock), lanes.rate), lanes.enter);
    const auto above = [&](std::uint8_t code) HWY_ATTR {
        return hn::And(inside, hn::RebindMask(d, hn::Gt(found, hn::Set(ints, code - 1))));
    };
    const auto seen = above(VisibleBlocks::visible), fine = above(VisibleBlocks::fine);
    const bool seenAny = !hn::AllFalse(d, seen), fineAny = !hn::AllFalse(d, fine);
    // Rays that see nothing may be walked with others, but not in steps that are too wide for what they come
    // to see.
    const auto counts = fineAny ? fine : seenAny && !blocks.anyFine() ? seen : inside;
    const V ends = hn::IfThenElse(counts, leaves, hn::Set(d, farthest));
    return {seenAny, fineAny, hn::GetLane(hn::MinOfLanes(d, ends))};
}

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
