// SPDX-License-Identifier: GPL-3.0-or-later
// Second pass over the points of a hybrid volume: adds each to its cell, the meeting of a pixel and a slab. A cell holds
// the sums of weight (optical depth), weight * depth within the slab and half of weight * color; integers, so that the
// order does not matter.
#include "frame.glsl"
#include "splats.glsl"

layout(binding = 2) uniform usamplerBuffer masks;             // slab bits, first cell: [layer][pixel][word]
layout(std430, binding = 2) buffer Cells { uint cells[]; };   // [cell][weight, moment, red, green, blue]

uniform float unit;          // the weight of an optical depth of 1
uniform uvec2 pass;          // cells [x, x + y) are present

void count() {}

void touch(uint pixel, uint slab, float fraction, float opacity) {
    float weight = -log(1.0 - min(opacity, 0.9999)) * unit;
    uint word = (layer * uint(frame.band.x) * 64u + pixel) * wordCount + (slab >> 5);
    uvec2 mask = texelFetch(masks, int(word)).xy;
    uint bit = 1u << (slab & 31u);
    uint cell = mask.y + uint(bitCount(mask.x & (bit - 1u))) - pass.x;
    if (cell >= pass.y || (mask.x & bit) == 0u) return;
    uint first = uint(CELL) * cell;
    vec3 colors = 0.5 * weight * splatColor;
    atomicAdd(cells[first], uint(weight + 0.5));
    atomicAdd(cells[first + 1u], uint(weight * fraction + 0.5));
    atomicAdd(cells[first + 2u], uint(colors.r + 0.5));
    atomicAdd(cells[first + 3u], uint(colors.g + 0.5));
    atomicAdd(cells[first + 4u], uint(colors.b + 0.5));
}
