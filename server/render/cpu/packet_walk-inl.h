// SPDX-License-Identifier: GPL-3.0-or-later
//
// PacketWalk: the way of a vector of rays through slabs, volumes and points, front to back. Compiled once for
// each target (Highway's foreach_target), hence without #pragma once.
//
// Rays of a packet stand at the same depth. Where no points are, samples lie at multiples of the packet's
// stretch, whatever was skipped, so that the picture depends neither on what is skipped nor on the width of
// the vectors.
#if defined(MOTE_PACKET_WALK_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_PACKET_WALK_INL_H
#undef MOTE_PACKET_WALK_INL_H
#else
#define MOTE_PACKET_WALK_INL_H
#endif

#include <algorithm>
#include <cmath>

#include "server/render/cpu/light-inl.h"
#include "server/render/cpu/packet.h"
#include "server/render/cpu/slab_points-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

class PacketWalk {
  public:
    HWY_INLINE PacketWalk(const CompositeFrame& frame, const Packet& packet, std::size_t lane)
        : frame_(frame), packet_(packet), lane_(lane), layers_(frame.layers.size()) {
        for (std::size_t l = 0; l < layers_; ++l) sight_[l] = {};
    }

    Light run() {
        const auto slabs = frame_.slabs;
        std::uint32_t at = 0;
        while (at < slabs && !light_.gone()) {
            const std::uint32_t next = packet_.nextPoints(at);
            if (at < next && packet_.anyHit) walkClear(static_cast<float>(at), static_cast<float>(next));
            if (next >= slabs || light_.gone()) break;
            mixSlab(next);
            at = next + 1;
        }
        return light_;
    }

  private:
    /// What is known of a layer's volume ahead: visible somewhere, or nowhere, before `until`.
    struct Sight {
        bool visible = false;
        float until = -1.0F;
        float sampledAt = -1.0F;  ///< slab of the sample that is kept in front_
    };
    struct alignas(64) StoredSample {
        Lanes way, density, integral, slope;
    };

    /// Looks ahead from a slab: as far as the first ray's next block, or over all blocks around in which
    /// nothing can be seen.
    HWY_NOINLINE void look(std::size_t l, float slab) {
        const PacketRays& rays = packet_.rays[l];
        Sight& sight = sight_[l];
        sight.visible = false;
        sight.until = frame_.slabs + 1.0F;
        if (!rays.hit || slab >= rays.farthest) return;
        if (slab < rays.nearest) {
            sight.until = rays.nearest;
            return;
        }
        const Floats d;
        const Ints ints;
        const VisibleBlocks& blocks = *frame_.layers[l].visible.blocks;
        const RayLanes lanes(rays, lane_);
        const V way = lanes.way(hn::Set(d, slab));
        const V x = hn::MulAdd(way, lanes.travelX, lanes.entryX);
        const V y = hn::MulAdd(way, lanes.travelY, lanes.entryY);
        const V z = hn::MulAdd(way, lanes.travelZ, lanes.entryZ);
        const int bits = static_cast<int>(blocks.edgeBits());
        const IntV side = hn::Set(ints, static_cast<std::int32_t>(blocks.side()));
        const IntV blockX = hn::ShiftRightSame(hn::ConvertTo(ints, x), bits);
        const IntV blockY = hn::ShiftRightSame(hn::ConvertTo(ints, y), bits);
        const IntV blockZ = hn::ShiftRightSame(hn::ConvertTo(ints, z), bits);
        const IntV index = hn::Add(hn::Mul(hn::Add(hn::Mul(blockZ, side), blockY), side), blockX);
        const auto* const distances = reinterpret_cast<const std::int32_t*>(blocks.distances());
        const IntV distance = hn::And(hn::GatherOffset(ints, distances, index), hn::Set(ints, 255));
        const IntV around = hn::Max(distance, hn::Set(ints, 1));
        const auto ahead = [&](IntV block, V place, const Lanes& inverse) HWY_ATTR {
            const V edge = hn::Set(d, static_cast<float>(1U << blocks.edgeBits()));
            const V low = hn::ConvertTo(d, hn::Add(hn::Sub(block, around), hn::Set(ints, 1)));
            const V high = hn::ConvertTo(d, hn::Add(block, around));
            const V share = hn::LoadU(d, inverse.data() + lane_);
            return hn::Max(hn::Mul(hn::MulSub(low, edge, place), share),
                           hn::Mul(hn::MulSub(high, edge, place), share));
        };
        const V inBlock =
            hn::Min(ahead(blockX, x, rays.inverse[0]),
                    hn::Min(ahead(blockY, y, rays.inverse[1]), ahead(blockZ, z, rays.inverse[2])));
        const auto inside = hn::Lt(way, hn::Set(d, 1.0F));
        const V leaves = hn::Add(hn::Div(hn::Add(way, inBlock), lanes.rate), lanes.enter);
        const auto seen = hn::And(inside, hn::RebindMask(d, hn::Eq(distance, hn::Zero(ints))));
        sight.visible = !hn::AllFalse(d, seen);
        sight.until = hn::GetLane(hn::MinOfLanes(d, hn::IfThenElse(inside, leaves, hn::Set(d, sight.until))));
        // Where the way is too short to be worth a leap, it is walked.
        if (!(sight.until >= slab + packet_.stretch)) {
            sight.visible = true;
            sight.until = slab + packet_.stretch;
        }
    }

    /// The layers, as bits, whose volumes may be seen from a slab on; `until`: how far this holds.
    std::uint32_t visibleFrom(float slab, float& until) {
        std::uint32_t visible = 0;
        until = frame_.slabs + 1.0F;
        for (std::size_t l = 0; l < layers_; ++l) {
            Sight& sight = sight_[l];
            if (slab >= sight.until) look(l, slab);
            if (sight.visible) visible |= 1U << l;
            until = std::min(
                until, sight.visible ? std::max(sight.until, slab + 2.0F * packet_.stretch) : sight.until);
        }
        return visible;
    }

    /// From a slab to another, between which there are no points.
    HWY_NOINLINE void walkClear(float from, float to) {
        const float stretch = packet_.stretch;
        float done = from;   // gathered up to here
        float clear = from;  // nothing is seen up to here
        while (clear < to) {
            float until = 0.0F;
            const std::uint32_t visible = visibleFrom(clear, until);
            if (visible == 0) {
                clear = until;
                continue;
            }
            const float start = std::max(done, std::floor(clear / stretch) * stretch);
            const float stop =
                std::min(std::max(std::ceil(until / stretch) * stretch, start + 0.5F * stretch), to);
            if ((visible & (visible - 1)) == 0) {
                march(static_cast<std::size_t>(hwy::Num0BitsBelowLS1Bit_Nonzero32(visible)), start, stop);
            } else {
                mix(visible, start, stop, nullptr);
            }
            if (light_.gone()) return;
            done = clear = stop;
        }
    }

    /// The volume of one layer alone.
    HWY_NOINLINE void march(std::size_t l, float from, float to) {
        const Floats d;
        const VolumeSource source(frame_.layers[l].visible);
        const RayLanes rays(packet_.rays[l], lane_);
        const V length = hn::LoadU(d, packet_.rays[l].length.data() + lane_);
        Light light = light_;
        Sample front = frontAt(l, source, rays, from);
        const float stretch = packet_.stretch;
        for (float number = std::floor(from / stretch) + 1.0F, at = from; at < to; ++number) {
            at = std::min(number * stretch, to);
            const Sample back = sampleAt(source, rays, hn::Set(d, at));
            const V tau = hn::Mul(hn::Mul(meanExtinction(front, back), hn::Sub(back.way, front.way)), length);
            if (!hn::AllTrue(d, hn::Le(tau, hn::Zero(d)))) {
                light.gather(hn::Max(tau, hn::Zero(d)), colorBetween(source, front, back));
                if (light.gone()) break;
            }
            front = back;
        }
        light_ = light;
        keepFront(l, front, to);
    }

    HWY_INLINE Sample frontAt(std::size_t l, const VolumeSource& source, const RayLanes& rays, float slab) {
        const Floats d;
        if (sight_[l].sampledAt != slab) return sampleAt(source, rays, hn::Set(d, slab));
        return loadFront(l);
    }
    HWY_INLINE Sample loadFront(std::size_t l) const {
        const Floats d;
        const StoredSample& stored = fronts_[l];
        return {hn::Load(d, stored.way.data()), hn::Load(d, stored.density.data()),
                hn::Load(d, stored.integral.data()), hn::Load(d, stored.slope.data())};
    }
    HWY_INLINE void storeFront(std::size_t l, const Sample& sample) {
        const Floats d;
        StoredSample& stored = fronts_[l];
        hn::Store(sample.way, d, stored.way.data());
        hn::Store(sample.density, d, stored.density.data());
        hn::Store(sample.integral, d, stored.integral.data());
        hn::Store(sample.slope, d, stored.slope.data());
    }
    HWY_INLINE void keepFront(std::size_t l, const Sample& sample, float slab) {
        storeFront(l, sample);
        sight_[l].sampledAt = slab;
    }

    /// A slab with points of some layer.
    HWY_NOINLINE void mixSlab(std::uint32_t slab) {
        std::uint32_t visible = 0;
        const float from = static_cast<float>(slab);
        for (float at = from; packet_.anyHit && at < from + 1.0F;) {
            float until = 0.0F;
            visible |= visibleFrom(at, until);
            at = until;
        }
        SlabPoints points;
        const std::uint32_t layers = points.read(frame_, packet_, slab, lane_);
        if (visible == 0 && (layers & (layers - 1)) == 0) {
            gatherAlone(points);
        } else {
            mix(visible, from, from + 1.0F, &points);
        }
    }

    /// Points of one layer with no volume about: where they stand does not matter.
    void gatherAlone(const SlabPoints& points) {
        const Floats d;
        const glm::vec3& color = frame_.layers[points.layer[0]].pointColor;
        light_.gather(hn::Load(d, points.tau[0].data()), hn::Set(d, color.x), hn::Set(d, color.y),
                      hn::Set(d, color.z));
    }

    /// Volumes of some layers and points, if any, evenly mixed. Each ray has its own cuts.
    HWY_NOINLINE void mix(std::uint32_t visible, float from, float to, const SlabPoints* points) {
        const Floats d;
        for (std::size_t l = 0; l < layers_; ++l) {
            if ((visible >> l & 1U) == 0 || sight_[l].sampledAt == from) continue;
            const VolumeSource source(frame_.layers[l].visible);
            storeFront(l, sampleAt(source, RayLanes(packet_.rays[l], lane_), hn::Set(d, from)));
        }
        const V end = hn::Set(d, to);
        V at = hn::Set(d, from);
        const V stretch = hn::Set(d, visible != 0 ? packet_.stretch : to - from);
        float number = std::floor(from / packet_.stretch) + 1.0F;
        while (!light_.gone() && !hn::AllFalse(d, hn::Lt(at, end))) {
            V next = end;
            if (points != nullptr) {
                next = points->nextCut(at, hn::Min(end, hn::Add(at, stretch)));
                next = hn::Min(hn::Max(next, hn::Add(at, hn::Set(d, 1e-4F))), end);
            } else {
                next = hn::Set(d, std::min(number * packet_.stretch, to));
                ++number;
            }
            Matter matter;
            if (points != nullptr) points->addSpread(at, next, matter);
            addVolumes(visible, next, matter);
            light_.gather(matter);
            if (points != nullptr) {
                Matter single;
                points->addSingle(at, next, single);
                light_.gather(single);
            }
            at = next;
        }
        for (std::size_t l = 0; l < layers_; ++l) {
            if ((visible >> l & 1U) != 0) sight_[l].sampledAt = to;
        }
    }

    HWY_INLINE void addVolumes(std::uint32_t visible, V next, Matter& matter) {
        const Floats d;
        for (; visible != 0; visible &= visible - 1) {
            const auto l = static_cast<std::size_t>(hwy::Num0BitsBelowLS1Bit_Nonzero32(visible));
            const VolumeSource source(frame_.layers[l].visible);
            const Sample front = loadFront(l);
            const Sample back = sampleAt(source, RayLanes(packet_.rays[l], lane_), next);
            const V length = hn::LoadU(d, packet_.rays[l].length.data() + lane_);
            const V tau =
                hn::Max(hn::Mul(hn::Mul(meanExtinction(front, back), hn::Sub(back.way, front.way)), length),
                        hn::Zero(d));
            matter.add(tau, colorBetween(source, front, back));
            storeFront(l, back);
        }
    }

    const CompositeFrame& frame_;
    const Packet& packet_;
    std::size_t lane_;
    std::size_t layers_;
    Light light_;
    std::array<Sight, Packet::mostLayers> sight_;
    std::array<StoredSample, Packet::mostLayers> fronts_;
};

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
