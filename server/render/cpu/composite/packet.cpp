// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/composite/packet.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

namespace mote::render {
namespace {

// More segments in one packet than any box of 512 cells needs, unless it is squeezed to a plate.
constexpr float mostSegments = 65536.0F;
// Slabs are told in single precision, to 1/16384 of one: a step must lead on.
constexpr float leastSegment = 1.0F / 2048.0F;
constexpr double thinnest = 1e-12;  // a way through the box, slabs, that is worth walking

struct Way {
    glm::dvec3 from, to;  // in the box
    double enter, leave;  // slabs
};

/// Where origin + s * speed, s from 0 to `slabs`, is in the box and not cut away. False where it is not, and
/// where a number is not finite.
bool clip(const glm::dvec3& origin, const glm::dvec3& speed, double slabs, std::span<const HalfSpace> clips,
          Way& way) {
    way.enter = 0.0;
    way.leave = slabs;
    for (int axis = 0; axis < 3; ++axis) {
        const double inverse = 1.0 / (std::abs(speed[axis]) < 1e-200 ? 1e-200 : speed[axis]);
        const double one = -origin[axis] * inverse, other = (1.0 - origin[axis]) * inverse;
        way.enter = std::max(way.enter, std::min(one, other));
        way.leave = std::min(way.leave, std::max(one, other));
    }
    for (const HalfSpace& side : clips) {
        const double height = glm::dot(side.normal, origin) - side.distance;
        const double rise = glm::dot(side.normal, speed);
        if (rise > 0.0) way.enter = std::max(way.enter, -height / rise);
        if (rise < 0.0) way.leave = std::min(way.leave, -height / rise);
        if (rise == 0.0 && height < 0.0) way.leave = -1.0;
    }
    way.from = glm::clamp(origin + way.enter * speed, 0.0, 1.0);
    way.to = glm::clamp(origin + way.leave * speed, 0.0, 1.0);
    const double sum = way.enter + way.leave + glm::dot(origin + speed, glm::dvec3(1.0));
    return std::isfinite(sum) && way.leave - way.enter > thinnest;
}

}  // namespace

void PacketRays::aim(const CompositeFrame& frame, const RayMap& rays, const PacketPlaces& places,
                     const BoxSpace& space) {
    meets = hit = false;
    crowded_ = 0.0;
    for (std::uint32_t i = 0; i < Tile::packetPixels; ++i) {
        const double right = (places[i].x / frame.width * 2.0 - 1.0) * frame.window.x;
        const double up = (1.0 - places[i].y / frame.height * 2.0) * frame.window.y;
        Way way;
        const bool met = clip(rays.entry[0] + right * rays.entry[1] + up * rays.entry[2],
                              rays.advance[0] + right * rays.advance[1] + up * rays.advance[2], frame.slabs,
                              space.clips, way);
        if (!met) way = {glm::dvec3(0.5), glm::dvec3(0.5), -1.0, 0.0};
        const glm::dvec3 travelled = way.to - way.from;
        const glm::dvec3 cells = travelled * space.cells;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const int a = static_cast<int>(axis);
            entry[axis][i] = static_cast<float>(way.from[a] * space.cells[a] + space.shift);
            travel[axis][i] = static_cast<float>(cells[a]);
            inverse[axis][i] = static_cast<float>(1.0 / (std::abs(cells[a]) < 1e-6 ? 1e-6 : cells[a]));
        }
        enterMean_[i] = way.enter;
        leaveMean_[i] = way.leave;
        length[i] = static_cast<float>(glm::length(space.toLayer * travelled));
        if (!met) continue;
        meets = true;
        crowded_ = std::max(crowded_, glm::length(cells) / (way.leave - way.enter) * space.samples);
    }
}

void PacketRays::enterSection(const FrameSection& section) {
    const double end = section.nearMean + section.slabs * section.meanSlab;
    const auto slabOf = [&](double mean) {
        return section.firstSlab + (mean - section.nearMean) / section.meanSlab;
    };
    hit = false;
    nearest = std::numeric_limits<float>::max();
    farthest = 0.0F;
    for (std::size_t i = 0; i < Tile::packetPixels; ++i) {
        const double slab = slabOf(enterMean_[i]);
        const double share = section.meanSlab / (leaveMean_[i] - enterMean_[i]);
        enter[i] = static_cast<float>(slab);
        rate[i] = static_cast<float>(share);
        start[i] = static_cast<float>(-slab * share);
        if (leaveMean_[i] <= section.nearMean || enterMean_[i] >= end || leaveMean_[i] <= 0.0) continue;
        hit = true;
        nearest = std::min(nearest, enter[i]);
        farthest = std::max(farthest, static_cast<float>(slabOf(leaveMean_[i])));
    }
    const auto slabs = static_cast<float>(section.slabs);
    const auto first = static_cast<float>(section.firstSlab);
    nearest = std::max(nearest, first);
    farthest = std::min(farthest, first + slabs);
    segment = static_cast<float>(1.0 / (crowded_ * section.meanSlab));
    segment = std::clamp(segment, std::max((farthest - nearest) / mostSegments, leastSegment), slabs);
}

void Packet::setRays(const CompositeFrame& frame, const PacketPlaces& places) {
    anyHit = false;
    hitCount_ = 0;
    glm::dvec2 low = places[0], high = places[0];
    for (const auto& place : places) {
        low = glm::min(low, place);
        high = glm::max(high, place);
    }
    const double edge = std::max(high.x - low.x, high.y - low.y);
    for (std::size_t f = 0; f < frame.fields.size(); ++f) {
        const FrameField& field = frame.fields[f];
        rays[f].meets = false;
        if (field.visible.seen.blocks == nullptr || !field.screen.meets(low.x, low.y, edge)) continue;
        rays[f].aim(frame, field.rays, places, field.space);
        if (!rays[f].meets) continue;
        anyHit = true;
        hits_[hitCount_++] = f;
    }
}

std::array<SlabBits, Tile::packets> occupiedSlabs(std::span<const TileCells> points, const TileDots* dots,
                                                  std::uint32_t slabs) {
    std::array<SlabBits, Tile::packets> occupied{};
    const auto add = [&](std::uint32_t slab, std::uint64_t packets) {
        for (; packets != 0; packets &= packets - 1)
            occupied[static_cast<std::size_t>(std::countr_zero(packets))][slab / 64] |= 1ULL << slab % 64;
    };
    for (const auto& layer : points) {
        for (std::uint32_t i = 0; i < layer.slabs(); ++i) add(layer.firstSlab() + i, layer.occupied(i));
    }
    for (std::uint32_t slab = 0; dots != nullptr && slab < slabs; ++slab) add(slab, dots->occupied(slab));
    return occupied;
}

void Packet::setPoints(const CompositeFrame& frame, std::span<const TileCells> cells,
                       const TileDots* tileDots, std::uint32_t packet, const SlabBits& occupied,
                       std::uint32_t x, std::uint32_t y) {
    points = cells;
    dots = tileDots;
    number = packet;
    slabs_ = frame.slabs;
    occupied_ = occupied;
    anyPoints = std::any_of(occupied_.begin(), occupied_.end(), [](std::uint64_t bits) { return bits != 0; });
    if (anyPoints) setColors(frame, x, y);
}

void Packet::setColors(const CompositeFrame& frame, std::uint32_t x, std::uint32_t y) {
    for (std::size_t l = 0; l < frame.points.size(); ++l) {
        const FramePointLook& look = frame.points[l];
        const bool shaded = !look.shades.empty() && l < points.size() && points[l].shaded();
        for (std::uint32_t i = 0; i < Tile::packetPixels; ++i) {
            const std::uint32_t column = x + i % Tile::packetEdge, row = y + i / Tile::packetEdge;
            const bool own = look.colors != nullptr && column < frame.width && row < frame.height;
            const glm::vec3* color = own ? &look.colors->at(column, row) : &look.color;
            if (shaded) {
                const PixelShade& shade = points[l].shades()[number * Tile::packetPixels + i];
                if (shade.weight > 0.0F) color = &look.colorOf(shade);
            }
            for (std::size_t c = 0; c < 3; ++c) pointColors[l][c][i] = (*color)[static_cast<int>(c)];
        }
    }
}

void Packet::enter(const FrameSection& section) {
    sectionHits_ = 0;
    segment = static_cast<float>(section.slabs);
    for (std::size_t i = 0; i < hitCount_; ++i) {
        PacketRays& own = rays[hits_[i]];
        own.enterSection(section);
        if (!own.hit) continue;
        inSection_[sectionHits_++] = hits_[i];
        segment = std::min(segment, own.segment);
    }
}

std::uint32_t Packet::nextPoints(std::uint32_t slab) const {
    while (slab < slabs_) {
        const std::uint64_t ahead = occupied_[slab / 64] >> slab % 64;
        if (ahead != 0) return slab + static_cast<std::uint32_t>(std::countr_zero(ahead));
        slab = (slab / 64 + 1) * 64;
    }
    return slabs_;
}

}  // namespace mote::render
