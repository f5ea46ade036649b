// SPDX-License-Identifier: GPL-3.0-or-later
//
// PacketRays: where a packet's rays go through a box, a vector of them at a time.
#include <algorithm>
#include <array>
#include <limits>

#include "server/render/cpu/composite/packet.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/render/cpu/composite/rays_kernel.cpp"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, Tile::packetPixels>;
using Singles = hn::Rebind<float, Doubles>;
using Double = hn::VFromD<Doubles>;
using DoubleMask = hn::MFromD<Doubles>;

constexpr Doubles doubles;
constexpr Singles singles;

HWY_INLINE Double exact(double value) {
    return hn::Set(doubles, value);
}

HWY_INLINE void storeSingles(Double values, Lanes& out, std::size_t ray) {
    hn::StoreU(hn::DemoteTo(singles, values), singles, out.data() + ray);
}

/// What is not nearer to 0 than `least`, above it.
HWY_INLINE Double heldFromZero(Double value, double least) {
    return hn::IfThenElse(hn::Lt(hn::Abs(value), exact(least)), exact(least), value);
}

/// A place or a way of each ray of a vector, along x, y and z.
using Axes = std::array<Double, 3>;

HWY_INLINE double axisOf(const glm::dvec3& of, std::size_t axis) {
    return of[static_cast<int>(axis)];
}

HWY_INLINE Double dot(const Axes& one, const Axes& other) {
    return hn::Add(hn::Add(hn::Mul(one[0], other[0]), hn::Mul(one[1], other[1])), hn::Mul(one[2], other[2]));
}
HWY_INLINE Double dot(const glm::dvec3& one, const Axes& other) {
    return dot(Axes{exact(one.x), exact(one.y), exact(one.z)}, other);
}
HWY_INLINE Double lengthOf(const Axes& way) {
    return hn::Sqrt(dot(way, way));
}

/// As RayMap.
HWY_INLINE Axes linear(const std::array<glm::dvec3, 3>& map, Double right, Double up) {
    Axes sum;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const Double across =
            hn::Add(exact(axisOf(map[0], axis)), hn::Mul(right, exact(axisOf(map[1], axis))));
        sum[axis] = hn::Add(across, hn::Mul(up, exact(axisOf(map[2], axis))));
    }
    return sum;
}

/// Rays that are at origin + s * speed in the box, s in mean slabs.
struct Lines {
    Axes origin, speed;

    /// Held to the box.
    HWY_INLINE Axes at(Double s) const {
        Axes place;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const Double exactly = hn::Add(origin[axis], hn::Mul(s, speed[axis]));
            place[axis] = hn::Min(exact(1.0), hn::Max(exact(0.0), exactly));
        }
        return place;
    }
};

/// Between which s rays are in the box and not cut away.
struct Between {
    Double enter, leave;
    DoubleMask met;  ///< false also where a number is not finite

    HWY_INLINE Between(const Lines& lines, double slabs, std::span<const HalfSpace> clips)
        : enter(exact(0.0)), leave(exact(slabs)) {
        constexpr double thinnest = 1e-12;  // a way through the box, slabs, that is worth walking
        Double sum = exact(0.0);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const Double inverse = hn::Div(exact(1.0), heldFromZero(lines.speed[axis], 1e-200));
            const Double one = hn::Mul(hn::Neg(lines.origin[axis]), inverse);
            const Double other = hn::Mul(hn::Sub(exact(1.0), lines.origin[axis]), inverse);
            enter = hn::Max(hn::Min(other, one), enter);
            leave = hn::Min(hn::Max(other, one), leave);
            sum = hn::Add(sum, hn::Add(lines.origin[axis], lines.speed[axis]));
        }
        for (const HalfSpace& side : clips) cut(lines, side);
        sum = hn::Add(hn::Add(enter, leave), sum);
        const auto finite = hn::Le(hn::Abs(sum), exact(std::numeric_limits<double>::max()));
        met = hn::And(finite, hn::Gt(hn::Sub(leave, enter), exact(thinnest)));
    }

  private:
    HWY_INLINE void cut(const Lines& lines, const HalfSpace& side) {
        const Double zero = exact(0.0);
        const Double height = hn::Sub(dot(side.normal, lines.origin), exact(side.distance));
        const Double rise = dot(side.normal, lines.speed);
        const Double at = hn::Div(hn::Neg(height), rise);
        enter = hn::IfThenElse(hn::Gt(rise, zero), hn::Max(at, enter), enter);
        leave = hn::IfThenElse(hn::Lt(rise, zero), hn::Min(at, leave), leave);
        leave = hn::IfThenElse(hn::And(hn::Eq(rise, zero), hn::Lt(height, zero)), exact(-1.0), leave);
    }
};

/// Stores the ways of a vector of rays from ray `ray` on. Returns the most segments to a mean slab, 0 where
/// none meets the box; `meets`: set where one does.
HWY_INLINE Double aimVector(const Lines& lines, double slabs, const BoxSpace& space, std::size_t ray,
                            PacketRays& rays, RayWays& ways) {
    const Between between(lines, slabs, space.clips);
    const DoubleMask met = between.met;
    const Double enter = hn::IfThenElse(met, between.enter, exact(-1.0));
    const Double leave = hn::IfThenElse(met, between.leave, exact(0.0));
    const Axes from = lines.at(between.enter), to = lines.at(between.leave);
    Axes travelled, cells;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double scale = axisOf(space.cells, axis);
        travelled[axis] = hn::IfThenElseZero(met, hn::Sub(to[axis], from[axis]));
        cells[axis] = hn::Mul(travelled[axis], exact(scale));
        const Double entry = hn::IfThenElse(met, from[axis], exact(0.5));
        storeSingles(hn::Add(hn::Mul(entry, exact(scale)), exact(space.shift)), rays.entry[axis], ray);
        storeSingles(cells[axis], rays.travel[axis], ray);
        storeSingles(hn::Div(exact(1.0), heldFromZero(cells[axis], 1e-6)), rays.inverse[axis], ray);
    }
    Axes inLayer;
    for (int row = 0; row < 3; ++row)
        inLayer[static_cast<std::size_t>(row)] =
            dot(glm::dvec3(space.toLayer[0][row], space.toLayer[1][row], space.toLayer[2][row]), travelled);
    storeSingles(lengthOf(inLayer), rays.length, ray);
    hn::StoreU(enter, doubles, ways.enter.data() + ray);
    hn::StoreU(leave, doubles, ways.leave.data() + ray);
    rays.meets = rays.meets || !hn::AllFalse(doubles, met);
    const Double crowded = hn::Mul(hn::Div(lengthOf(cells), hn::Sub(leave, enter)), exact(space.samples));
    return hn::IfThenElseZero(met, crowded);
}

void aimRays(const CompositeFrame& frame, const RayMap& map, const PacketPlaces& places,
             const BoxSpace& space, PacketRays& rays, RayWays& ways) {
    const Double one = exact(1.0), two = exact(2.0);
    Double crowded = exact(0.0);
    rays.meets = rays.hit = false;
    for (std::size_t ray = 0; ray < places.size(); ray += hn::Lanes(doubles)) {
        Double x, y;
        hn::LoadInterleaved2(doubles, &places[ray].x, x, y);
        const Double right =
            hn::Mul(hn::Sub(hn::Mul(hn::Div(x, exact(frame.width)), two), one), exact(frame.window.x));
        const Double up =
            hn::Mul(hn::Sub(one, hn::Mul(hn::Div(y, exact(frame.height)), two)), exact(frame.window.y));
        const Lines lines{linear(map.entry, right, up), linear(map.advance, right, up)};
        crowded = hn::Max(crowded, aimVector(lines, frame.slabs, space, ray, rays, ways));
    }
    ways.crowded = hn::GetLane(hn::MaxOfLanes(doubles, crowded));
}

void enterRays(const FrameSection& section, const RayWays& ways, PacketRays& rays) {
    const double end = section.nearMean + section.slabs * section.meanSlab;
    const auto slabOf = [&](Double mean) HWY_ATTR {
        const Double slabs = hn::Div(hn::Sub(mean, exact(section.nearMean)), exact(section.meanSlab));
        return hn::Add(exact(section.firstSlab), slabs);
    };
    rays.hit = false;
    Double nearest = exact(std::numeric_limits<float>::max()), farthest = exact(0.0);
    for (std::size_t ray = 0; ray < ways.enter.size(); ray += hn::Lanes(doubles)) {
        const Double enter = hn::LoadU(doubles, ways.enter.data() + ray),
                     leave = hn::LoadU(doubles, ways.leave.data() + ray);
        const Double slab = slabOf(enter), share = hn::Div(exact(section.meanSlab), hn::Sub(leave, enter));
        storeSingles(slab, rays.enter, ray);
        storeSingles(share, rays.rate, ray);
        storeSingles(hn::Mul(hn::Neg(slab), share), rays.start, ray);
        const auto here = hn::And(hn::Gt(leave, exact(section.nearMean)), hn::Lt(enter, exact(end)));
        const auto hit = hn::And(here, hn::Gt(leave, exact(0.0)));
        rays.hit = rays.hit || !hn::AllFalse(doubles, hit);
        nearest = hn::Min(nearest, hn::IfThenElse(hit, slab, nearest));
        farthest = hn::Max(farthest, hn::IfThenElseZero(hit, slabOf(leave)));
    }
    rays.nearest = static_cast<float>(hn::GetLane(hn::MinOfLanes(doubles, nearest)));
    rays.farthest = static_cast<float>(hn::GetLane(hn::MaxOfLanes(doubles, farthest)));
}

}  // namespace
}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace mote::render {

HWY_EXPORT(aimRays);
HWY_EXPORT(enterRays);

void PacketRays::aim(const CompositeFrame& frame, const RayMap& map, const PacketPlaces& places,
                     const BoxSpace& space) {
    HWY_DYNAMIC_DISPATCH(aimRays)(frame, map, places, space, *this, ways_);
}

void PacketRays::enterSection(const FrameSection& section) {
    // More segments in one packet than any box of 512 cells needs, unless it is squeezed to a plate.
    constexpr float mostSegments = 65536.0F;
    // Slabs are told in single precision, to 1/16384 of one: a step must lead on.
    constexpr float leastSegment = 1.0F / 2048.0F;
    HWY_DYNAMIC_DISPATCH(enterRays)(section, ways_, *this);
    const auto slabs = static_cast<float>(section.slabs);
    const auto first = static_cast<float>(section.firstSlab);
    nearest = std::max(nearest, first);
    farthest = std::min(farthest, first + slabs);
    segment = static_cast<float>(1.0 / (ways_.crowded * section.meanSlab));
    segment = std::clamp(segment, std::max((farthest - nearest) / mostSegments, leastSegment), slabs);
}

}  // namespace mote::render
#endif  // HWY_ONCE
