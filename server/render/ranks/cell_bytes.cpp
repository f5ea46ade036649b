// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ranks/cell_bytes.h"

#include <array>
#include <bit>

#include "protocol/base/mote_check.h"
#include "server/render/ranks/byte_stream.h"

namespace mote::render {
namespace {

/// Which cells of a packet follow.
struct PacketHead {
    std::uint16_t number;  ///< slab, from the layer's first on, * Tile::packets + packet
    std::uint16_t cells;   ///< a bit each, from bit 0
};
static_assert(Tile::packetPixels == 16, "a bit each");
constexpr std::size_t mostPackets = 65536;

void packPacket(const TileCells& layer, std::uint32_t slab, std::uint32_t packet, ByteWriter& out) {
    const PointCell* const cells = layer.slab(slab) + std::size_t{packet} * Tile::packetPixels;
    std::array<PointCell, Tile::packetPixels> held;
    std::size_t count = 0;
    unsigned bits = 0;
    for (unsigned i = 0; i < Tile::packetPixels; ++i) {
        if (cells[i].weight == 0.0F) continue;
        bits |= 1U << i;
        held[count++] = cells[i];
    }
    if (count == 0) return;
    out.put(PacketHead{static_cast<std::uint16_t>(slab * Tile::packets + packet),
                       static_cast<std::uint16_t>(bits)});
    out.putAll(std::span<const PointCell>(held.data(), count));
}

/// Those of the packets that hold points, which a bit each tells, from bit 0.
void packShades(const TileCells& layer, ByteWriter& out) {
    std::uint64_t packets = 0;
    for (std::uint32_t slab = 0; slab < layer.slabs(); ++slab) packets |= layer.occupied(slab);
    out.put(packets);
    for (; packets != 0; packets &= packets - 1) {
        const auto first = static_cast<std::size_t>(std::countr_zero(packets)) * Tile::packetPixels;
        out.putAll(std::span(layer.shades() + first, Tile::packetPixels));
    }
}

void addShades(ByteReader& in, TileCells& layer) {
    for (auto packets = in.get<std::uint64_t>(); packets != 0; packets &= packets - 1) {
        std::array<PixelShade, Tile::packetPixels> more;
        in.getAll(more.data(), more.size());
        PixelShade* const shades =
            layer.shades() + static_cast<std::size_t>(std::countr_zero(packets)) * Tile::packetPixels;
        for (std::size_t i = 0; i < more.size(); ++i) {
            shades[i].weight += more[i].weight;
            shades[i].level += more[i].level;
        }
    }
}

Bytes packLayer(const TileCells& layer) {
    ByteWriter out;
    if (layer.shaded()) packShades(layer, out);
    for (std::uint32_t slab = 0; slab < layer.slabs(); ++slab) {
        for (std::uint64_t bits = layer.occupied(slab); bits != 0; bits &= bits - 1) {
            packPacket(layer, slab, static_cast<std::uint32_t>(std::countr_zero(bits)), out);
        }
    }
    return out.take();
}

void addLayer(std::span<const std::byte> packed, TileCells& layer) {
    ByteReader in(packed);
    if (layer.shaded()) addShades(in, layer);
    while (!in.atEnd()) {
        const auto head = in.get<PacketHead>();
        MOTE_CHECK(head.number < layer.slabs() * Tile::packets);
        PointCell* const cells = layer.cells() + std::size_t{head.number} * Tile::packetPixels;
        std::array<PointCell, Tile::packetPixels> held;
        in.getAll(held.data(), static_cast<std::size_t>(std::popcount(head.cells)));
        const PointCell* more = held.data();
        for (unsigned bits = head.cells; bits != 0; bits &= bits - 1, ++more) {
            PointCell& cell = cells[std::countr_zero(bits)];
            cell.weight += more->weight;
            cell.depth += more->depth;
        }
        layer.touched()[head.number] = 1;
    }
}

}  // namespace

std::size_t mostCellBytes(std::uint32_t slabs, std::size_t layers) {
    constexpr std::size_t packet = sizeof(PacketHead) + Tile::packetPixels * sizeof(PointCell);
    constexpr std::size_t shades = sizeof(std::uint64_t) + Tile::pixels * sizeof(PixelShade);
    return layers * (sizeof(std::uint64_t) + shades + std::size_t{slabs} * Tile::packets * packet);
}

Bytes packCells(std::span<const TileCells> layers) {
    ByteWriter out;
    for (const auto& layer : layers) {
        MOTE_CHECK(layer.slabs() * Tile::packets <= mostPackets);
        out.putList(packLayer(layer));
    }
    return out.take();
}

void addCells(std::span<const std::byte> packed, std::span<TileCells> layers) {
    ByteReader in(packed);
    for (auto& layer : layers) addLayer(in.getSpan(), layer);
    MOTE_CHECK(in.atEnd());
}

}  // namespace mote::render
