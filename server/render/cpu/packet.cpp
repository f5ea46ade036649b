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
    stretch = static_cast<float>(frame.slabs);
    for (std::size_t l = 0; l < frame.layers.size(); ++l) {
        rays[l].hit = false;
        const auto& visible = frame.layers[l].visible;
        const PixelRange& screen = frame.layers[l].screen;
        if (visible.volume == nullptr || x > screen.high.x || y > screen.high.y ||
            x + Tile::packetEdge < screen.low.x || y + Tile::packetEdge < screen.low.y)
            continue;
        rays[l].aim(frame, frame.layers[l].rays, x, y, visible.volume->size());
        if (!rays[l].hit) continue;
        anyHit = true;
        stretch = std::min(stretch, rays[l].stretch);
    }
    occupied_.fill(0);
    for (const auto& layer : points) {
        for (std::uint32_t slab = 0; slab < slabs_; ++slab)
            occupied_[slab / 64] |= (layer.occupied(slab) >> number & 1U) << slab % 64;
    }
    for (std::uint32_t slab = 0; dots != nullptr && slab < slabs_; ++slab)
        occupied_[slab / 64] |= (dots->occupied(slab) >> number & 1U) << slab % 64;
    anyPoints = std::any_of(occupied_.begin(), occupied_.end(), [](std::uint64_t bits) { return bits != 0; });
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
