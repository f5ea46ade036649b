// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/composite.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "server/render/cpu/packet.h"
#include "server/render/cpu/packet_sights.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/render/cpu/composite.cpp"
#include <hwy/foreach_target.h>
// After foreach_target: these are compiled once for each target.
#include "server/render/cpu/packet_walk-inl.h"
#include "server/render/cpu/pixel_store-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mote::render::HWY_NAMESPACE {

/// A walk for each vector of a packet's rays.
template <std::size_t... number>
HWY_INLINE std::array<PacketWalk, sizeof...(number)> walksOf(const CompositeFrame& frame,
                                                             const Packet& packet, PacketSights& sights,
                                                             std::index_sequence<number...>) {
    return {PacketWalk(frame, packet, number * hn::MaxLanes(Floats()), sights)...};
}

/// `pixels`: of the packet, row by row, as words of the picture's format.
void compositePacket(const CompositeFrame& frame, Packet& packet, PacketSights& sights,
                     std::uint32_t* pixels) {
    constexpr std::size_t lanes = hn::MaxLanes(Floats());
    const std::size_t words = bytesPerPixel(frame.format) / sizeof(std::uint32_t);
    auto walks = walksOf(frame, packet, sights, std::make_index_sequence<Tile::packetPixels / lanes>());
    for (const auto& section : frame.sections) {
        packet.enter(section);
        sights.clear();
        for (auto& walk : walks) walk.run(section);
    }
    for (std::size_t i = 0; i < walks.size(); ++i)
        storePixels(frame, walks[i].light(), pixels + i * lanes * words);
}

}  // namespace mote::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace mote::render {
namespace {

HWY_EXPORT(compositePacket);

/// The rows of a packet's pixels that lie in the picture.
void writePacket(const CompositeFrame& frame, const std::uint8_t* pixels, std::uint32_t x, std::uint32_t y,
                 std::uint8_t* picture) {
    const std::size_t size = bytesPerPixel(frame.format);
    const std::uint32_t columns = std::min(Tile::packetEdge, frame.width - x);
    const std::uint32_t rows = std::min(Tile::packetEdge, frame.height - y);
    for (std::uint32_t row = 0; row < rows; ++row) {
        std::memcpy(picture + (std::size_t{y + row} * frame.width + x) * size,
                    pixels + row * Tile::packetEdge * size, columns * size);
    }
}

}  // namespace

void compositeTile(const CompositeFrame& frame, Tile tile, std::span<const TileCells> points,
                   const TileDots* dots, std::uint8_t* picture) {
    constexpr std::uint32_t across = Tile::edge / Tile::packetEdge;
    const std::size_t size = bytesPerPixel(frame.format);
    alignas(64) std::array<std::uint32_t, 2 * Tile::packetPixels> words{};
    auto* const pixels = reinterpret_cast<std::uint8_t*>(words.data());
    Packet packet;
    PacketSights sights;
    for (std::uint32_t number = 0; number < Tile::packets; ++number) {
        const std::uint32_t x = tile.column * Tile::edge + number % across * Tile::packetEdge;
        const std::uint32_t y = tile.row * Tile::edge + number / across * Tile::packetEdge;
        if (x >= frame.width || y >= frame.height) continue;
        packet.set(frame, points, dots, number, x, y);
        if (packet.anyHit || packet.anyPoints) {
            HWY_DYNAMIC_DISPATCH(compositePacket)(frame, packet, sights, words.data());
        } else {
            for (std::size_t i = 0; i < Tile::packetPixels; ++i)
                std::memcpy(pixels + i * size, frame.blank.data(), size);
        }
        writePacket(frame, pixels, x, y, picture);
    }
}

}  // namespace mote::render
#endif  // HWY_ONCE
