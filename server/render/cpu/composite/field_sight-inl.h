// SPDX-License-Identifier: GPL-3.0-or-later
//
// FieldSight: what the rays of a packet meet of a volume ahead, by its blocks. Compiled once for each target
// (Highway's foreach_target), hence without #pragma once.
#if defined(MOTE_FIELD_SIGHT_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_FIELD_SIGHT_INL_H
#undef MOTE_FIELD_SIGHT_INL_H
#else
#define MOTE_FIELD_SIGHT_INL_H
#endif

#include <algorithm>

#include "server/render/cpu/composite/density_sample-inl.h"
#include "server/render/cpu/composite/packet.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// What each ray of a packet sees ahead.
struct RaySights {
    static constexpr float outside = -1.0F;  ///< of the volume: nothing more is seen of it
    Lanes kind;                              ///< 0, VisibleBlocks::visible or fine; or `outside`
    Lanes until;                             ///< slab up to which the blocks are alike
};

/// What a vector of rays sees from a slab on, as far as their blocks, with those around them, are alike.
HWY_INLINE void lookAhead(const VisibleBlocks& blocks, const PacketRays& rays, std::size_t lane, float slab,
                          RaySights& out) {
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
    const V kind = hn::ConvertTo(d, hn::Sub(found, around));
    hn::StoreU(hn::IfThenElse(inside, kind, hn::Set(d, RaySights::outside)), d, out.kind.data() + lane);
    hn::StoreU(leaves, d, out.until.data() + lane);
}

/// What the rays of a packet see in common of a volume from a slab on; `farthest` where they see none of it.
HWY_INLINE FieldSight lookAhead(const VisibleBlocks& blocks, const PacketRays& rays, float slab,
                                float farthest) {
    RaySights sights;
    for (std::size_t lane = 0; lane < Tile::packetPixels; lane += hn::Lanes(Floats()))
        lookAhead(blocks, rays, lane, slab, sights);
    constexpr float visible{VisibleBlocks::visible}, fine{VisibleBlocks::fine};
    const float most = *std::max_element(sights.kind.values.begin(), sights.kind.values.end());
    FieldSight sight{most >= visible, most >= fine, farthest};
    // Rays that see nothing may be walked with others, but not in steps that are too wide for what they come
    // to see.
    const float least = sight.fine ? fine : sight.visible && !blocks.anyFine() ? visible : 0.0F;
    for (std::size_t i = 0; i < Tile::packetPixels; ++i) {
        if (sights.kind[i] >= least) sight.until = std::min(sight.until, sights.until[i]);
    }
    return sight;
}

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
