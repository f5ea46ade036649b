// SPDX-License-Identifier: GPL-3.0-or-later
//
// Tile: a square of the picture that one thread draws at a time, small enough that its cells stay in a core's
// cache. Its pixels are counted in packets of 4 x 4 that are walked together as the lanes of vectors. Pure
// functions.
#pragma once

#include <cstdint>

namespace mote::render {

struct Tile {
    static constexpr std::uint32_t edge = 32;             ///< pixels
    static constexpr std::uint32_t pixels = edge * edge;  ///< also those beyond the picture's border
    static constexpr std::uint32_t packetEdge = 4;
    static constexpr std::uint32_t packetPixels = packetEdge * packetEdge;
    static constexpr std::uint32_t packets = pixels / packetPixels;

    std::uint32_t column = 0;  ///< of tiles; its first pixel is column * edge
    std::uint32_t row = 0;

    /// Where the pixel (x, y) of a tile, both below `edge`, stands among its pixels: packet by packet, the
    /// packets row by row, and row by row in each.
    static constexpr std::uint32_t pixelIndex(std::uint32_t x, std::uint32_t y) {
        const std::uint32_t packet = (y / packetEdge) * (edge / packetEdge) + x / packetEdge;
        return packet * packetPixels + (y % packetEdge) * packetEdge + x % packetEdge;
    }
};

/// Tiles across `pixels` of width or height.
constexpr std::uint32_t tilesAcross(std::uint32_t pixels) {
    return (pixels + Tile::edge - 1) / Tile::edge;
}

}  // namespace mote::render
