// SPDX-License-Identifier: GPL-3.0-or-later
// One invocation a pixel, where a picture has one field of samples and nothing else: from brick to brick in which something
// is seen, front to back. A software rasteriser runs the body of a loop at least once, and both sides of a condition: so
// light is looked up in an outer loop, when the inner one has found something for it. Compiled with LAYERS, GRIDS and
// SECTIONS 1, MIXED and SLOPES.
#include "frame.glsl"
#include "pixel.glsl"
#include "ray.glsl"
#include "matter.glsl"
#include "grid.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(std430, binding = 6) readonly buffer Tiles { uint tiles[]; };      // to be drawn

layout(location = 0) uniform uint firstTile;   // of this dispatch, in `tiles`

void gatherBrick(float from, float to) {
    Way way = wayFrom(0u, from);
    while (way.at < to && transmittance > opaque) {
        while (way.at < to && way.tau < lightEvery) goOn(0u, to, way);
        gather(litMatter(0u, way));
    }
}

void walk(vec2 at) {
    sectionEnd = float(frame.band.y);
    aimBox(0u, at);
    clipWay(0u);
    unitLength[0] = gridLength(0u);
    float depth = enters[0];
    while (depth < leaves[0] && transmittance > opaque) {
        float from = depth;
        do {
            from = depth;
            // However close the borders, each step must go on in single precision.
            depth = min(max(depth + enterBrick(0u, depth), depth + 1e-4), leaves[0]);
        } while (!brickSeen[0] && depth < leaves[0]);
        gatherBrick(brickSeen[0] ? from : depth, depth);
    }
}

void main() {
    uint tile = tiles[firstTile + gl_WorkGroupID.x];
    // Blocks of 4 x 2 pixels: neighbours in both directions are alike the longest.
    uint i = gl_LocalInvocationIndex;
    uvec2 inTile = uvec2((i & 3u) | ((i >> 3) & 1u) << 2, ((i >> 2) & 1u) | (i >> 4) << 1);
    uvec2 place = uvec2(tile % uint(frame.picture.z), tile / uint(frame.picture.z)) * 8u + inTile;
    uint row = place.y + uint(frame.picture.w) * 8u;   // of the picture; place.y is the band's
    uvec2 size = uvec2(frame.picture.xy);
    if (place.x >= size.x || row >= size.y) return;
    vec2 ndc = (vec2(place.x, row) + 0.5) / vec2(size) * 2.0 - 1.0;
    walk(vec2(ndc.x, -ndc.y) * frame.window.xy);
    store(place.y * size.x + place.x, light, transmittance);
}
