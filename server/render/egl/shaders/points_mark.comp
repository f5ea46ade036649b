// SPDX-License-Identifier: GPL-3.0-or-later
// First pass over the points: which slabs of which pixels hold points at all.
#include "frame.glsl"
#include "bends.glsl"
#include "points.glsl"

layout(std430, binding = 0) buffer Masks { uint masks[]; };   // [layer][pixel][word][slab bits, first cell]

void touch(uint pixel, uint slab, float fraction, float coverage) {
    uint at = 2u * ((layer * uint(frame.band.x) * 64u + pixel) * wordCount + (slab >> 5));
    uint bit = 1u << (slab & 31u);
    // Most points of a dense region find their bit set: reading is much cheaper than an atomic.
    if ((masks[at] & bit) == 0u) atomicOr(masks[at], bit);
}
