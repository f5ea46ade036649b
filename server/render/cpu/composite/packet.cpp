// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/composite/packet.h"

#include <algorithm>
#include <bit>
#include <glm/common.hpp>

namespace mote::render {
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
