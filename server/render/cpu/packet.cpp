// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/packet.h"

#include <algorithm>
#include <bit>

namespace mote::render {

void Packet::set(const CompositeFrame& frame, std::span<const TileCells> cells, const TileDots* tileDots,
                 std::uint32_t packet, std::uint32_t x, std::uint32_t y) {
    points = cells;
    dots = tileDots;
    number = packet;
    slabs_ = frame.slabs;
    anyHit = false;
    hitCount_ = 0;
    for (std::size_t f = 0; f < frame.fields.size(); ++f) {
        const FrameField& field = frame.fields[f];
        rays[f].meets = false;
        if (field.visible.sight.blocks == nullptr || !field.screen.meets(x, y, Tile::packetEdge)) continue;
        rays[f].aim(frame, field.rays, x, y, field.space);
        if (!rays[f].meets) continue;
        anyHit = true;
        hits_[hitCount_++] = f;
    }
    occupied_.fill(0);
    for (const auto& layer : points) {
        for (std::uint32_t i = 0; i < layer.slabs(); ++i) {
            const std::uint32_t slab = layer.firstSlab() + i;
            occupied_[slab / 64] |= (layer.occupied(i) >> number & 1U) << slab % 64;
        }
    }
    for (std::uint32_t slab = 0; dots != nullptr && slab < slabs_; ++slab)
        occupied_[slab / 64] |= (dots->occupied(slab) >> number & 1U) << slab % 64;
    anyPoints = std::any_of(occupied_.begin(), occupied_.end(), [](std::uint64_t bits) { return bits != 0; });
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
