// SPDX-License-Identifier: GPL-3.0-or-later
// First pass over the points: which slabs of which pixels hold points at all. SPLATS: of a hybrid volume.
#include "frame.glsl"
#if SPLATS
#include "splats.glsl"
#else
#include "points.glsl"
#endif

layout(std430, binding = 0) buffer Masks { uint masks[]; };   // [layer][pixel][word][slab bits, first cell]

#if SPLATS
// Points are counted in several places, so that few meet in one.
layout(std430, binding = 4) buffer Counters { uint cellCount, tileCounts[3], splatCounts[256]; };

void count() {   // each band of the picture goes through all points
    if (frame.picture.w == 0) atomicAdd(splatCounts[16u * (gl_WorkGroupID.x & 15u)], 1u);
}
#endif

void touch(uint pixel, uint slab, float fraction, float coverage) {
    uint at = 2u * ((layer * uint(frame.band.x) * 64u + pixel) * wordCount + (slab >> 5));
    uint bit = 1u << (slab & 31u);
    // Most points of a dense region find their bit set: reading is much cheaper than an atomic.
    if ((masks[at] & bit) == 0u) atomicOr(masks[at], bit);
}
