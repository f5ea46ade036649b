// SPDX-License-Identifier: GPL-3.0-or-later
// Gives each pixel room for as many cells as it has marked slabs, and lists the tiles that are not blank: those with
// visible volume, and plain ones. One invocation a tile. Where a tile's room lies depends on the order of execution; what is drawn does
// not.
#include "frame.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Masks { uint masks[]; };
layout(std430, binding = 1) writeonly buffer Offsets { uint offsets[]; };
layout(std430, binding = 4) buffer Counters { uint cellCount, plainCount, volumeCount; };
layout(std430, binding = 5) readonly buffer VolumeMasks { uint volumeMasks[]; };
layout(std430, binding = 8) writeonly buffer Tiles { uint tiles[]; };   // plain ones from 0, the others from the number of tiles

uint marked(uint layer, uint pixel) {
    uint words = (layer * uint(frame.band.x) * 64u + pixel) * wordCount;
    uint count = 0u;
    for (uint i = 0u; i < wordCount; ++i) count += uint(bitCount(masks[words + i]));
    return count;
}

void main() {
    uint tile = gl_GlobalInvocationID.x;
    uint tileCount = uint(frame.band.x);
    if (tile >= tileCount) return;
    uint volume = 0u;
    for (uint layer = 0u; layer < layerCount; ++layer) {
        for (uint i = 0u; i < wordCount; ++i) volume |= volumeMasks[(layer * tileCount + tile) * wordCount + i];
    }
    uint total = 0u;
    for (uint pixel = tile * 64u; pixel < tile * 64u + 64u; ++pixel) {
        for (uint layer = 0u; layer < layerCount; ++layer) total += marked(layer, pixel);
    }
    if (volume != 0u) {
        tiles[tileCount + atomicAdd(volumeCount, 1u)] = tile;
    } else if (total != 0u) {
        tiles[atomicAdd(plainCount, 1u)] = tile;
    }
    uint next = total == 0u ? 0u : atomicAdd(cellCount, total);
    for (uint pixel = tile * 64u; pixel < tile * 64u + 64u; ++pixel) {
        for (uint layer = 0u; layer < layerCount; ++layer) {
            offsets[pixel * layerCount + layer] = next;
            next += marked(layer, pixel);
        }
    }
}
