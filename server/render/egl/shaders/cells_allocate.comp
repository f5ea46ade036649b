// SPDX-License-Identifier: GPL-3.0-or-later
// Gives each pixel room for as many cells as it has marked slabs, and lists the tiles that are not blank, by what
// they hold. One invocation a tile. Where a tile's room lies depends on the order of execution; what is drawn does
// not.
#include "frame.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Masks { uint masks[]; };   // [layer][pixel][word][slab bits, first cell]
layout(std430, binding = 1) writeonly buffer Offsets { uint offsets[]; };   // of each pixel: its first cell
layout(std430, binding = 4) buffer Counters { uint cellCount, tileCounts[3]; };
layout(std430, binding = 5) readonly buffer VolumeMasks { uint volumeMasks[]; };
// Tiles with points and without volume; from the number of tiles, those without points and with volume; from twice it,
// those with both.
layout(std430, binding = 8) writeonly buffer Tiles { uint tiles[]; };

uint wordsOf(uint layer, uint pixel) {
    return 2u * (layer * uint(frame.band.x) * 64u + pixel) * wordCount;
}

uint cellsOf(uint tile) {
    uint count = 0u;
    for (uint layer = 0u; layer < layerCount; ++layer) {
        uint first = wordsOf(layer, tile * 64u);
        for (uint word = first; word < first + 128u * wordCount; word += 2u) count += uint(bitCount(masks[word]));
    }
    return count;
}

void allocate(uint tile, uint next) {
    for (uint pixel = tile * 64u; pixel < tile * 64u + 64u; ++pixel) {
        offsets[pixel] = next;
        for (uint layer = 0u; layer < layerCount; ++layer) {
            uint first = wordsOf(layer, pixel);
            for (uint word = first; word < first + 2u * wordCount; word += 2u) {
                masks[word + 1u] = next;
                next += uint(bitCount(masks[word]));
            }
        }
    }
}

void main() {
    uint tile = gl_GlobalInvocationID.x;
    uint tileCount = uint(frame.band.x);
    if (tile >= tileCount) return;
    uint volume = 0u;
    for (uint layer = 0u; layer < layerCount; ++layer) {
        for (uint i = 0u; i < wordCount; ++i) volume |= volumeMasks[(layer * tileCount + tile) * wordCount + i];
    }
    uint count = cellsOf(tile);
    if ((volume | count) != 0u) {
        uint kind = volume == 0u ? 0u : count == 0u ? 1u : 2u;
        tiles[kind * tileCount + atomicAdd(tileCounts[kind], 1u)] = tile;
    }
    allocate(tile, count == 0u ? 0u : atomicAdd(cellCount, count));
}
