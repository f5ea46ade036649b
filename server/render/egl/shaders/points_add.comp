// SPDX-License-Identifier: GPL-3.0-or-later
// Second pass over the points: adds each to its cell, the meeting of a pixel and a slab. A cell holds the sum of
// weights and the sum of weight * depth within the slab; integers, so that the order does not matter.
#include "frame.glsl"
#include "points.glsl"

layout(std430, binding = 1) readonly buffer Offsets { uint offsets[]; };   // first cell: [pixel][layer]
layout(std430, binding = 2) buffer Cells { uint cells[]; };                // [cell][weight, moment]

layout(location = 4) uniform float unit;          // the weight of a whole point
layout(location = 5) uniform float opacity;       // of a whole point
layout(location = 6) uniform float inverseTau;    // 1 / -log(1 - opacity)
layout(location = 7) uniform uvec2 pass;          // cells [x, x + y) are present; pixels that start there are drawn

void touch(uint pixel, uint slab, float fraction, float coverage) {
    uint words = (layer * uint(frame.band.x) * 64u + pixel) * wordCount;
    uint word = words + (slab >> 5);
    uint bit = 1u << (slab & 31u);
    uint bits = masks[word];
    uint first = offsets[pixel * layerCount];
    if (first - pass.x >= pass.y || (bits & bit) == 0u) return;
#if LAYERS > 1
    first = offsets[pixel * layerCount + layer];
#endif
    uint cell = first - pass.x + uint(bitCount(bits & (bit - 1u)));
    for (uint i = words; i < word; ++i) cell += uint(bitCount(masks[i]));
    float weight = unit;
#if DISCS
    if (coverage < 1.0) weight *= min(-log(1.0 - opacity * coverage) * inverseTau, 1.0);
#endif
    atomicAdd(cells[2u * cell], uint(weight + 0.5));
    atomicAdd(cells[2u * cell + 1u], uint(weight * fraction + 0.5));
}
