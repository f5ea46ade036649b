// SPDX-License-Identifier: GPL-3.0-or-later
// Gives each pixel room for as many cells as it has marked slabs, and lists the tiles that are not blank, by what
// they hold. One invocation a tile. Where a tile's room lies depends on the order of execution; what is drawn does
// not.
// POINTS, DOTS: 0 where none are drawn.
#include "frame.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Masks { uint masks[]; };   // [layer][pixel][word][slab bits, first cell]
layout(binding = 2) uniform usamplerBuffer slabBits;          // the same, quicker to read
layout(std430, binding = 1) writeonly buffer Offsets { uint offsets[]; };   // each pixel's first cell
layout(std430, binding = 4) buffer Counters { uint cellCount, tileCounts[3]; };
layout(std430, binding = 5) readonly buffer VolumeMasks { uint volumeMasks[]; };
#if DOTS
layout(binding = 3) uniform usamplerBuffer dotLists;          // where each tile's list begins
#endif
// Tiles with points and without volume; from the number of tiles, those without points and with volume or dots; from
// twice it, those with points and volume.
layout(std430, binding = 6) writeonly buffer Tiles { uint tiles[]; };

uint wordsOf(uint layer, uint pixel) {
    return 2u * (layer * uint(frame.band.x) * 64u + pixel) * wordCount;
}

uint cellsOf(uint tile) {
    uint count = 0u;
    for (uint layer = 0u; layer < frame.counts.x; ++layer) {
        uint first = (layer * uint(frame.band.x) + tile) * 64u * wordCount;
        for (uint word = first; word < first + 64u * wordCount; ++word) {
            count += uint(bitCount(texelFetch(slabBits, int(word)).x));
        }
    }
    return count;
}

void allocate(uint firstPixel, uint pixels, uint next) {
    for (uint pixel = firstPixel; pixel < firstPixel + pixels; ++pixel) {
        offsets[pixel] = next;
        for (uint layer = 0u; layer < frame.counts.x; ++layer) {
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
    for (uint layer = 0u; layer < frame.counts.x; ++layer) {
        for (uint i = 0u; i < wordCount; ++i) volume |= volumeMasks[(layer * tileCount + tile) * wordCount + i];
    }
    uint count = POINTS != 0 ? cellsOf(tile) : 0u;
    uint dots = 0u;
#if DOTS
    dots = texelFetch(dotLists, int(tile) + 1).x - texelFetch(dotLists, int(tile)).x;
#endif
    if ((volume | count | dots) != 0u) {
        uint kind = count == 0u ? 1u : volume == 0u ? 0u : 2u;
        tiles[kind * tileCount + atomicAdd(tileCounts[kind], 1u)] = tile;
    }
#if POINTS
    // Not behind a condition, which a software rasteriser does not skip: a loop without turns.
    allocate(tile * 64u, count == 0u ? 0u : 64u, count == 0u ? 0u : atomicAdd(cellCount, count));
#endif
}
