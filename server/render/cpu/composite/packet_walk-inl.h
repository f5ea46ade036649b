// SPDX-License-Identifier: GPL-3.0-or-later
//
// PacketWalk: the way of a vector of rays through slabs, fields, points and dots, front to back. Compiled
// once for each target (Highway's foreach_target), hence without #pragma once.
//
// The picture does not depend on the width of the vectors: what is skipped begins and ends at multiples of
// the packet's segment and is the same for all vectors of a packet (PacketSights), and whatever else adapts,
// steps and their end, is decided ray by ray.
#if defined(MOTE_PACKET_WALK_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MOTE_PACKET_WALK_INL_H
#undef MOTE_PACKET_WALK_INL_H
#else
#define MOTE_PACKET_WALK_INL_H
#endif

#include <limits>

#include "server/render/cpu/composite/field_march-inl.h"
#include "server/render/cpu/composite/field_sight-inl.h"
#include "server/render/cpu/composite/packet.h"
#include "server/render/cpu/composite/slab_points-inl.h"
#include "server/render/cpu/composite/told_borders-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

class PacketWalk {
  public:
    /// Not inlined, for it is called where no target is chosen. `sights`: of the packet in the section that
    /// it goes through, for all vectors of its rays.
    PacketWalk(const CompositeFrame& frame, const Packet& packet, std::size_t lane, PacketSights& sights)
        : dots_(packet, lane), frame_(frame), packet_(packet), lane_(lane), known_(sights) {}

    /// Goes through a section that the packet has entered; from front to back through all of them.
    void run(const FrameSection& section) {
        enter(section);
        std::uint32_t at = section.firstSlab;
        if (aloneAndKnown()) {
            if (!light_.gone())
                march(packet_.hitFields()[0], static_cast<float>(at), static_cast<float>(end_));
            return;
        }
        while (at < end_ && !light_.gone()) {
            const std::uint32_t next = std::min(packet_.nextPoints(at), end_);
            if (at < next && !packet_.hitFields().empty())
                walkClear(static_cast<float>(at), static_cast<float>(next));
            if (next >= end_ || light_.gone()) break;
            mixSlab(next);
            at = next + 1;
        }
    }
    const Light& light() const { return light_; }

    /// Likewise through fields alone, telling the light at borders of slabs; up to slab `end` at most.
    void run(const FrameSection& section, ToldBorders& told,
             std::uint32_t end = std::numeric_limits<std::uint32_t>::max()) {
        enter(section);
        end_ = std::min(end_, end);
        told_ = &told;
        if (!packet_.hitFields().empty() && !light_.gone())
            walkClear(static_cast<float>(section.firstSlab), static_cast<float>(end_));
        told.tellTo(static_cast<float>(section.endSlab()), light_);
    }

  private:
    void enter(const FrameSection& section) {
        frontAt_.fill(-1.0F);
        sights_.fill({});
        asked_.fill(0);
        end_ = section.endSlab();
    }
    struct StoredSample {
        Lanes way, density, integral, slope, red, green, blue;
    };

    /// Whether all that there is is one field in which each ray finds its own way past what shows nothing.
    bool aloneAndKnown() const {
        if (packet_.anyPoints || packet_.dots != nullptr || packet_.hitFields().size() != 1) return false;
        const std::size_t f = packet_.hitFields()[0];
        return frame_.cellByCell && isGrid(f) && grid(f).dark != nullptr;
    }
    /// Only fields that the packet's rays hit are ever asked for.
    bool isGrid(std::size_t f) const { return frame_.fields[f].grid.has_value(); }
    const GridSamples& grid(std::size_t f) const { return *frame_.fields[f].grid; }
    DensitySource density(std::size_t f) const { return DensitySource(frame_.fields[f].visible); }

    /// Looks ahead from a slab in a field that some ray hits.
    HWY_NOINLINE FieldSight look(std::size_t f, float slab) const {
        const PacketRays& rays = packet_.rays[f];
        const float farthest = static_cast<float>(end_) + 1.0F;
        if (slab >= rays.farthest) return {false, false, farthest};
        if (slab < rays.nearest) return {false, false, rays.nearest};
        auto sight = lookAhead(*frame_.fields[f].visible.seen.blocks, rays, slab, farthest);
        // Where the way is too short to be worth a leap, it is walked.
        if (!(sight.until >= slab + packet_.segment)) return {true, true, slab + packet_.segment};
        // Blocks may be alike as far as the box reaches, and so beyond it: nothing is left to walk there.
        sight.until = std::min(sight.until, rays.farthest);
        return sight;
    }

    /// The fields, as bits, that may be seen from a slab on; `until`: how far this holds. In double
    /// precision, in which multiples of a segment are exact.
    std::uint32_t visibleFrom(double slab, double& until) {
        const double segment = packet_.segment;
        std::uint32_t visible = 0;
        until = end_ + 1.0;
        for (const std::size_t f : packet_.hitFields()) {
            FieldSight& sight = sights_[f];
            if (slab >= sight.until)
                sight = known_.of(f, asked_[f]++, [&] { return look(f, static_cast<float>(slab)); });
            if (sight.visible) visible |= 1U << f;
            const double holds = sight.until;
            // Who goes from cell to cell passes over clear cells in less time than a look takes.
            const double least = slab + (byCells(1U << f) ? 32.0 : 2.0) * segment;
            until = std::min(until, sight.visible ? std::max(holds, least) : holds);
        }
        if (visible == 0 || packet_.hitFields().size() == 1) return visible;
        // What is walked ends at a multiple of the segment: another field must not begin before it.
        for (const std::size_t f : packet_.hitFields()) {
            const double begins = std::floor(sights_[f].until / segment) * segment;
            if (sights_[f].visible || begins > until) continue;
            if (begins < slab + segment) visible |= 1U << f;
            until = std::max(begins, slab + segment);
        }
        return visible;
    }

    /// Goes from a slab to another, between which there are no points.
    HWY_NOINLINE void walkClear(float from, float to) {
        const double segment = packet_.segment;
        double done = from;   // gathered up to here
        double clear = from;  // nothing is seen up to here
        while (clear < to) {
            double until = 0.0;
            const std::uint32_t visible = visibleFrom(clear, until);
            if (visible == 0) {
                clear = until;
                continue;
            }
            const double start = std::max(done, std::floor(clear / segment) * segment);
            double stop = std::max(std::ceil(until / segment) * segment, start + 0.5 * segment);
            // Who goes from cell to cell goes as far as the same is seen.
            while (byCells(visible) && stop < to && visibleFrom(stop, until) == visible)
                stop = std::max(std::ceil(until / segment) * segment, stop + 0.5 * segment);
            done = clear = std::min(stop, double{to});
            walkSeen(visible, static_cast<float>(start), static_cast<float>(done));
            if (light_.gone()) return;
        }
    }

    /// Whether the fields are one whose rays go from cell to cell.
    bool byCells(std::uint32_t visible) const {
        return (visible & (visible - 1)) == 0 && frame_.cellByCell &&
               !isGrid(hwy::Num0BitsBelowLS1Bit_Nonzero32(visible));
    }

    /// Likewise in some fields, of which something may be seen there.
    HWY_INLINE void walkSeen(std::uint32_t visible, float from, float to) {
        const bool alone = (visible & (visible - 1)) == 0;
        const std::size_t first = hwy::Num0BitsBelowLS1Bit_Nonzero32(visible);
        while (from < to && !light_.gone()) {
            float end = to;
            // Who goes from cell to cell tells borders on the way.
            if (told_ != nullptr && !byCells(visible)) {
                told_->tellTo(from, light_);
                end = std::min(end, told_->next());
            }
            if (alone) {
                march(first, from, end);
            } else {
                mix(visible, from, end, nullptr);
            }
            from = end;
        }
    }

    /// One field alone.
    HWY_NOINLINE void march(std::size_t f, float from, float to) {
        const PacketRays& rays = packet_.rays[f];
        Light light = light_;
        if (isGrid(f)) {
            marchGrid(f, from, to, light);
        } else {
            const Sample front = frontOf(f, from);
            const DensitySource source = density(f);
            storeFront(f,
                       frame_.cellByCell
                           ? marchDensities(source, rays, front, from, to, light)
                           : marchEvenly(source, rays, lane_, front, from, to, packet_.segment, light),
                       to);
        }
        light_ = light;
    }
    HWY_INLINE Sample marchDensities(const DensitySource& source, const PacketRays& rays, const Sample& front,
                                     float from, float to, Light& light) const {
        const V end = RayLanes(rays, lane_).way(hn::Set(Floats(), to));
        if (told_ == nullptr) return marchCells(source, rays, lane_, front, end, light, NoBorders());
        return marchCells(source, rays, lane_, front, end, light,
                          BorderLights(*told_, RayLanes(rays, lane_), from, to, light));
    }
    HWY_INLINE void marchGrid(std::size_t f, float from, float to, Light& light) {
        const PacketRays& rays = packet_.rays[f];
        const GridSource source(grid(f));
        const Sample front = frontOf(f, from);
        const float segment = sights_[f].fine ? packet_.segment : packet_.segment * grid(f).stride;
        storeFront(f,
                   frame_.cellByCell ? marchGridCells(source, rays, lane_, front, to, light)
                                     : marchGridEvenly(source, rays, lane_, front, from, to, segment, light),
                   to);
    }

    /// A slab with some points or dots.
    HWY_NOINLINE void mixSlab(std::uint32_t slab) {
        const float from = static_cast<float>(slab);
        std::uint32_t visible = 0;
        for (double at = from; !packet_.hitFields().empty() && at < from + 1.0F;) {
            double until = 0.0;
            visible |= visibleFrom(at, until);
            at = until;
        }
        SlabPoints points;
        const std::uint32_t layers = points.read(frame_, packet_, slab, lane_);
        const bool dots = packet_.hasDots(slab);
        if (visible == 0 && layers == 0) {
            dots_.pass(hn::Set(Floats(), from + 1.0F), light_);
        } else if (!dots && visible == 0 && (layers & (layers - 1)) == 0) {
            // Points of one look with no field about: where they stand does not matter.
            const auto& color = points.color[0];
            const Floats d;
            light_.gather(hn::Load(d, points.tau[0].data()), hn::Load(d, color[0]), hn::Load(d, color[1]),
                          hn::Load(d, color[2]));
        } else {
            mix(visible, from, from + 1.0F, &points);
        }
    }

    /// Some fields and points, if any, evenly mixed, dots between them. Each ray has its own cuts.
    HWY_NOINLINE void mix(std::uint32_t visible, float from, float to, const SlabPoints* points) {
        const Floats d;
        for (std::uint32_t left = visible; left != 0; left &= left - 1) {
            const std::size_t f = hwy::Num0BitsBelowLS1Bit_Nonzero32(left);
            storeFront(f, frontOf(f, from), to);
        }
        const V end = hn::Set(d, to);
        V at = hn::Set(d, from);
        dots_.pass(at, light_);
        while (!light_.gone() && !hn::AllFalse(d, hn::Lt(at, end))) {
            V next = nextSample(visible, at, end);
            if (points != nullptr) next = points->nextCut(at, next);
            next = dots_.nextCut(next);
            // However close the cuts, each step must go on in single precision.
            next = hn::Min(hn::Max(next, hn::Add(at, hn::Set(d, 1e-4F))), end);
            Matter matter = thinFields(visible, at, next);
            if (points != nullptr) points->addSpread(at, next, matter);
            light_.gather(matter);
            if (points != nullptr) {
                Matter single;
                points->addSingle(at, next, single);
                light_.gather(single);
            }
            dots_.pass(next, light_);
            at = next;
        }
    }

    /// How far fields may be sampled in one step; at most to `end`.
    HWY_INLINE V nextSample(std::uint32_t visible, V at, V end) const {
        const Floats d;
        if (visible == 0) return end;
        if (!frame_.cellByCell) return hn::Min(end, hn::Add(at, hn::Set(d, packet_.segment)));
        // Several fields are mixed in each step: it must be short where they change differently.
        if ((visible & (visible - 1)) != 0) end = hn::Min(end, hn::Add(at, hn::Set(d, packet_.segment)));
        for (; visible != 0; visible &= visible - 1) {
            const std::size_t f = hwy::Num0BitsBelowLS1Bit_Nonzero32(visible);
            end = hn::Min(end, hn::Add(at, thinSegment(f)));
            const RayLanes rays(packet_.rays[f], lane_);
            // Also where rays enter and leave, so that what lies in one field and not in another is not
            // mixed.
            const V way = rays.way(at);
            const V plane = hn::Min(leaveCell(f, rays, way), hn::Set(d, 1.0F));
            const V cut = hn::Add(hn::Div(plane, rays.rate), rays.enter);
            const V next = hn::IfThenElse(hn::Gt(rays.enter, at), rays.enter, cut);
            end = hn::IfThenElse(hn::Lt(way, hn::Set(d, 1.0F)), hn::Min(end, next), end);
        }
        return end;
    }

    /// The way at which rays next leave their cell.
    HWY_INLINE V leaveCell(std::size_t f, const RayLanes& rays, V way) const {
        if (isGrid(f)) return GridPlace(grid(f), axesOf(rays, packet_.rays[f], lane_), way).leave;
        return nextPlane(rays, packet_.rays[f], lane_, way);
    }

    /// So far, slabs, that a field which goes on as at its front absorbs little: what is mixed in one step
    /// is seen through each other.
    HWY_INLINE V thinSegment(std::size_t f) const {
        const Floats d;
        const PacketRays& rays = packet_.rays[f];
        const V slope = hn::Load(d, samples_[f][front_[f]].slope.data());
        const V unit =
            hn::Mul(hn::LoadU(d, rays.length.data() + lane_), hn::LoadU(d, rays.rate.data() + lane_));
        const V segment = hn::Div(hn::Set(d, 0.5F), hn::Max(hn::Mul(slope, unit), hn::Set(d, 1e-20F)));
        return hn::Max(segment, hn::Set(d, packet_.segment / 16.0F));
    }

    /// What lies in the fields up to `next`, which comes nearer for rays that would mix too much in one
    /// step, since nothing in it is in front of anything else.
    HWY_INLINE Matter thinFields(std::uint32_t visible, V at, V& next) {
        const Floats d;
        constexpr int mostTries = 4;
        Matter matter = fieldsTo(visible, next);
        for (int i = 1; i < mostTries; ++i) {
            const auto deep = hn::And(light_.seen(), hn::Gt(matter.tau, hn::Set(d, 0.5F)));
            if (hn::AllFalse(d, deep)) break;
            const V nearer = hn::MulAdd(hn::Sub(next, at), hn::Set(d, 0.375F), at);
            next = hn::IfThenElse(deep, nearer, next);
            matter = fieldsTo(visible, next);
        }
        for (std::uint32_t left = visible; left != 0; left &= left - 1)
            front_[hwy::Num0BitsBelowLS1Bit_Nonzero32(left)] ^= 1U;
        return matter;
    }

    /// The samples at `next` are kept beside those at the front.
    HWY_INLINE Matter fieldsTo(std::uint32_t visible, V next) {
        const Floats d;
        Matter matter;
        for (; visible != 0; visible &= visible - 1) {
            const std::size_t f = hwy::Num0BitsBelowLS1Bit_Nonzero32(visible);
            const RayLanes rays(packet_.rays[f], lane_);
            const Sample front = loadFront(f);
            const V length = hn::LoadU(d, packet_.rays[f].length.data() + lane_);
            const V way = rays.way(next);
            if (isGrid(f)) {
                store(gridTo(f, rays, front, way, matter), samples_[f][front_[f] ^ 1U]);
                continue;
            }
            const DensitySource source = density(f);
            if (frame_.cellByCell) {
                const PartReads reads = readPart(source, rays, partBetween(source, rays, front.way, way));
                const Sample back = sampleOf(reads.back);
                takePart(source, rays, front, reads, back, length, light_.seen(),
                         [&](V depth, const Sample& one, const Sample& other, V mean)
                             HWY_ATTR { matter.add(hn::Mul(depth, length), one, other, mean); });
                store(back, samples_[f][front_[f] ^ 1U]);
            } else {
                const Sample back = sampleAt(source, rays, way);
                const VolumePiece piece(front, back);
                matter.add(hn::Mul(piece.depth, length), front, back, piece.mean);
                store(back, samples_[f][front_[f] ^ 1U]);
            }
        }
        return matter;
    }

    HWY_INLINE Sample gridTo(std::size_t f, const RayLanes& rays, const Sample& front, V way,
                             Matter& matter) const {
        const V length = hn::LoadU(Floats(), packet_.rays[f].length.data() + lane_);
        const MatterSums sums{matter};
        const GridSource source(grid(f));
        const ThreeAxes axes = axesOf(rays, packet_.rays[f], lane_);
        if (frame_.cellByCell) {
            return takeCells(
                source, axes, front, way, length, [&]() HWY_ATTR { return light_.seen(); }, sums);
        }
        const Sample back = sampleAt(source, axes, way);
        takeEvenly(source, axes, front, back, length, sums);
        return back;
    }

    /// The sample at the front of what comes next; it may be there already.
    HWY_INLINE Sample frontOf(std::size_t f, float slab) const {
        if (frontAt_[f] == slab) return loadFront(f);
        const RayLanes rays(packet_.rays[f], lane_);
        const V way = rays.way(hn::Set(Floats(), slab));
        if (isGrid(f)) return sampleAt(GridSource(grid(f)), axesOf(rays, packet_.rays[f], lane_), way);
        return sampleAt(density(f), rays, way);
    }
    HWY_INLINE Sample loadFront(std::size_t f) const {
        const Floats d;
        const StoredSample& stored = samples_[f][front_[f]];
        return {hn::Load(d, stored.way.data()),      hn::Load(d, stored.density.data()),
                hn::Load(d, stored.integral.data()), hn::Load(d, stored.slope.data()),
                hn::Load(d, stored.red.data()),      hn::Load(d, stored.green.data()),
                hn::Load(d, stored.blue.data())};
    }
    HWY_INLINE void storeFront(std::size_t f, const Sample& sample, float slab) {
        store(sample, samples_[f][front_[f]]);
        frontAt_[f] = slab;
    }
    HWY_INLINE static void store(const Sample& sample, StoredSample& stored) {
        const Floats d;
        hn::Store(sample.way, d, stored.way.data());
        hn::Store(sample.density, d, stored.density.data());
        hn::Store(sample.integral, d, stored.integral.data());
        hn::Store(sample.slope, d, stored.slope.data());
        hn::Store(sample.red, d, stored.red.data());
        hn::Store(sample.green, d, stored.green.data());
        hn::Store(sample.blue, d, stored.blue.data());
    }

    DotCursor dots_;
    // The sample at the front of each field, and one beside it.
    std::array<std::array<StoredSample, 2>, Packet::mostFields> samples_;
    std::array<std::uint32_t, Packet::mostFields> front_{};  // which of the two
    std::array<float, Packet::mostFields> frontAt_;          // its slab
    Light light_;
    const CompositeFrame& frame_;
    const Packet& packet_;
    std::size_t lane_;
    PacketSights& known_;
    ToldBorders* told_ = nullptr;                        // null: nobody is told
    std::array<std::size_t, Packet::mostFields> asked_;  // sights of each field
    std::array<FieldSight, Packet::mostFields> sights_;
    std::uint32_t end_ = 0;  // slab, of the section
};

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
