// SPDX-License-Identifier: GPL-3.0-or-later
// Second pass over the points: adds each to its cell, the meeting of a pixel and a slab. A cell holds the sum of
// weights and the sum of weight * depth within the slab; integers, so that the order does not matter. FLAT: the only
// pass, where depth does not matter (points of one colour and nothing else); a cell is a pixel and holds the weights.
#include "frame.glsl"
#include "bends.glsl"
#include "points.glsl"

layout(binding = 2) uniform usamplerBuffer masks;             // slab bits, first cell: [layer][pixel][word]
layout(std430, binding = 2) buffer Cells { uint cells[]; };   // [cell][weight, moment]

uniform float unit;          // the weight of a whole point
uniform float opacity;       // of a whole point; 0: its optical depth is in proportion to coverage
uniform float inverseTau;    // 1 / -log(1 - opacity)
uniform uvec2 pass;          // cells [x, x + y) are present

void touch(uint pixel, uint slab, float fraction, float coverage) {
    float weight = unit * weighs;
#if DISCS
    if (coverage < 1.0) weight *= opacity > 0.0 ? min(-log(1.0 - opacity * coverage) * inverseTau, 1.0) : coverage;
#endif
#if FLAT
    atomicAdd(cells[pixel], uint(weight + 0.5));
#else
    uint word = (layer * uint(frame.band.x) * 64u + pixel) * wordCount + (slab >> 5);
    uvec2 mask = texelFetch(masks, int(word)).xy;
    uint bit = 1u << (slab & 31u);
    uint cell = mask.y + uint(bitCount(mask.x & (bit - 1u))) - pass.x;
    if (cell >= pass.y || (mask.x & bit) == 0u) return;
    atomicAdd(cells[2u * cell], uint(int(weight + 0.5)));
    atomicAdd(cells[2u * cell + 1u], uint(int(weight * fraction + 0.5)));
#endif
}
