// SPDX-License-Identifier: GPL-3.0-or-later
// One invocation a pixel, where a picture has one hybrid volume and nothing else: from brick to brick in which something
// is seen and, with POINTS, from cell to cell of its points, front to back. A software rasteriser runs the body of a loop
// at least once, and both sides of a condition: so light is looked up in an outer loop, when the inner one has found
// something for it. Compiled with LAYERS, HYBRIDS and SECTIONS 1, WORDS and POINTS (0: the tiles hold none).
#include "frame.glsl"
#include "pixel.glsl"
#include "ray.glsl"
#include "hybrid.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
#if POINTS
layout(binding = 9) uniform usamplerBuffer masks;                         // slab bits, first cell: [pixel][word]
layout(binding = 10) uniform usamplerBuffer cells;                        // weight, moment, half of weight * color: word by word
layout(std430, binding = 1) readonly buffer Offsets { uint offsets[]; };   // of each pixel: its first cell
#endif
layout(std430, binding = 6) readonly buffer Tiles { uint tiles[]; };      // to be drawn

layout(location = 0) uniform uint firstTile;   // of this dispatch, in `tiles`
layout(location = 1) uniform uvec2 pass;       // cells [x, x + y) are present; pixels that start there are drawn

const float beyond = 1e30;   // slabs
float cellDepth = beyond;    // of the next points in this pixel

#if POINTS
uint cellWord = 0u, cellBits = 0u;   // the next word of masks; the slabs ahead of the one before
int nextCell;
vec4 cellMatter;                     // optical depth times color; optical depth

// Goes on to the next slab with points. They stand together at their mean depth: how many there are is not known.
void findCell(uint pixel) {
    while (cellBits == 0u && cellWord < wordCount) {
        uvec2 mask = texelFetch(masks, int(pixel * wordCount + cellWord)).xy;
        cellBits = mask.x;
        nextCell = 5 * int(mask.y - pass.x);
        ++cellWord;
    }
    float weight = float(texelFetch(cells, nextCell).x), moment = float(texelFetch(cells, nextCell + 1).x);
    vec3 colors = vec3(texelFetch(cells, nextCell + 2).x, texelFetch(cells, nextCell + 3).x,
                       texelFetch(cells, nextCell + 4).x);
    cellMatter = vec4(2.0 * colors, weight) * frame.layers[0].scale.x;
    float slab = float(int(cellWord) * 32 - 32 + findLSB(cellBits));
    cellDepth = cellBits == 0u ? beyond : slab + clamp(moment / max(weight, 1.0), 0.0, 1.0);
    cellBits &= cellBits - 1u;
    nextCell += 5;
}
#endif

// The points up to a depth.
void passCells(uint pixel, float to) {
#if POINTS
    while (cellDepth <= to) {
        gather(cellMatter);
        findCell(pixel);
    }
#endif
}

void gatherBrick(uint pixel, float from, float to) {
    Way way = wayFrom(0u, from);
    while (way.at < to && transmittance > opaque) {
        float until = min(to, cellDepth);
        while (way.at < until && transmittance > opaque) {
            while (way.at < until && way.tau < lightEvery) goOn(0u, until, way);
            gather(litMatter(0u, way));
        }
        passCells(pixel, way.at);
    }
}

void walk(uint pixel, vec2 at) {
    sectionEnd = float(frame.band.y);
    aimBox(0u, at);
    clipWay(0u);
    unitLength[0] = hybridLength(0u);
    float depth = enters[0];
    passCells(pixel, depth);
    while (depth < leaves[0] && transmittance > opaque) {
        float from = depth;
        do {
            from = depth;
            // However close the borders, each step must go on in single precision.
            depth = min(max(depth + enterBrick(0u, depth), depth + 1e-4), leaves[0]);
        } while (!brickSeen[0] && depth < min(leaves[0], cellDepth));
        gatherBrick(pixel, brickSeen[0] ? from : depth, depth);
        passCells(pixel, depth);
    }
    passCells(pixel, transmittance > opaque ? 2.0 * float(frame.band.y) : -1.0);
}

void main() {
    uint tile = tiles[firstTile + gl_WorkGroupID.x];
    // Blocks of 4 x 2 pixels: neighbours in both directions are alike the longest.
    uint i = gl_LocalInvocationIndex;
    uvec2 inTile = uvec2((i & 3u) | ((i >> 3) & 1u) << 2, ((i >> 2) & 1u) | (i >> 4) << 1);
    uvec2 place = uvec2(tile % uint(frame.picture.z), tile / uint(frame.picture.z)) * 8u + inTile;
    uint row = place.y + uint(frame.picture.w) * 8u;   // of the picture; place.y is the band's
    uint pixel = tile * 64u + inTile.y * 8u + inTile.x;
    uvec2 size = uvec2(frame.picture.xy);
    if (place.x >= size.x || row >= size.y) return;
#if POINTS
    if (offsets[pixel] - pass.x >= pass.y) return;
    findCell(pixel);
#endif
    vec2 ndc = (vec2(place.x, row) + 0.5) / vec2(size) * 2.0 - 1.0;
    walk(pixel, vec2(ndc.x, -ndc.y) * frame.window.xy);
    store(place.y * size.x + place.x, light, transmittance);
}
