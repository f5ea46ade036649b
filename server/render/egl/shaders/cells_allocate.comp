// SPDX-License-Identifier: GPL-3.0-or-later
// Gives each pixel room for as many cells as it has marked slabs. One invocation a tile. Where a tile's room lies
// depends on the order of execution; what is drawn does not.
#include "frame.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Masks { uint masks[]; };
layout(std430, binding = 1) writeonly buffer Offsets { uint offsets[]; };
layout(std430, binding = 4) buffer Counter { uint cellCount; };

layout(location = 0) uniform uint firstTile;

uint marked(uint layer, uint pixel) {
    uint words = (layer * uint(frame.band.x) * 64u + pixel) * wordCount;
    uint count = 0u;
    for (uint i = 0u; i < wordCount; ++i) count += uint(bitCount(masks[words + i]));
    return count;
}

void main() {
    uint tile = firstTile + gl_GlobalInvocationID.x;
    if (tile >= uint(frame.band.x)) return;
    uint total = 0u;
    for (uint pixel = tile * 64u; pixel < tile * 64u + 64u; ++pixel) {
        for (uint layer = 0u; layer < layerCount; ++layer) total += marked(layer, pixel);
    }
    uint next = total == 0u ? 0u : atomicAdd(cellCount, total);
    for (uint pixel = tile * 64u; pixel < tile * 64u + 64u; ++pixel) {
        for (uint layer = 0u; layer < layerCount; ++layer) {
            offsets[pixel * layerCount + layer] = next;
            next += marked(layer, pixel);
        }
    }
}
