// SPDX-License-Identifier: GPL-3.0-or-later
// Which slabs of which tiles can hold visible volume: each visible brick of cells marks the tiles and slabs that the
// box around its projection meets.
#include "frame.glsl"
#include "bends.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = 5) buffer VolumeMasks { uint volumeMasks[]; };   // [layer][tile][wordCount]
layout(std430, binding = 3) readonly buffer Bricks { uint bricks[]; };    // x | y << 10 | z << 20

layout(location = 0) uniform uint layer;
layout(location = 1) uniform uint brickCount;
layout(location = 2) uniform vec3 brickEdge;   // of the box
layout(location = 3) uniform vec3 brickShift;  // of all bricks' borders; the first brick reaches to the box's face

void mark(uint at, uint first, uint last) {   // slabs first to last, both included
    for (uint word = first >> 5; word <= last >> 5; ++word) {
        uint low = word == first >> 5 ? first & 31u : 0u;
        uint high = word == last >> 5 ? last & 31u : 31u;
        uint bits = (0xffffffffu << low) & (0xffffffffu >> (31u - high));
        if ((volumeMasks[at + word] & bits) != bits) atomicOr(volumeMasks[at + word], bits);
    }
}

void main() {
    if (gl_GlobalInvocationID.x >= brickCount) return;
    uint brick = bricks[gl_GlobalInvocationID.x];
    vec3 number = vec3(uvec3(brick, brick >> 10, brick >> 20) & 1023u);
    vec3 corner = number * brickEdge + brickShift;
    vec3 near = mix(corner, vec3(0.0), equal(number, vec3(0.0)));
    vec3 far = min(corner + brickEdge, vec3(1.0));
    vec2 low = vec2(1e30), high = vec2(-1e30);
    float front = 1e30, back = -1e30;
    bool across = false;   // reaches behind the eye: its projection is unbounded
    for (uint i = 0u; i < 8u; ++i) {
        vec3 at = mix(near, far, bvec3(uvec3(i, i >> 1, i >> 2) & 1u));
        vec4 screen = frame.layers[layer].boxToScreen * vec4(at, 1.0);
        front = min(front, screen.z);
        back = max(back, screen.z);
        across = across || screen.w <= 0.0;
        low = min(low, screen.xy / screen.w);
        high = max(high, screen.xy / screen.w);
    }
    front = bent(front);
    back = bent(back);
    if (back < 0.0 || front > bendShape.z) return;
    vec2 size = vec2(frame.picture.xy);
    if (across) {
        low = vec2(0.0);
        high = size;
    }
    // A little wider than computed, for rounding.
    low -= 0.1;
    high += 0.1;
    if (any(lessThan(high, vec2(0.0))) || any(greaterThan(low, size))) return;
    uvec2 firstTile = uvec2(clamp(low, vec2(0.0), size - 0.5)) >> 3;
    uvec2 lastTile = uvec2(clamp(high, vec2(0.0), size - 0.5)) >> 3;
    uint first = uint(clamp(front - 0.01, 0.0, bendShape.z - 0.5)) + uint(bendShape.y);
    uint last = uint(clamp(back + 0.01, 0.0, bendShape.z - 0.5)) + uint(bendShape.y);
    uint firstRow = uint(frame.picture.w);
    uint rows = (uint(frame.band.w) + 7u) >> 3;
    if (lastTile.y < firstRow) return;
    for (uint y = max(firstTile.y, firstRow); y <= min(lastTile.y, firstRow + rows - 1u); ++y) {
        for (uint x = firstTile.x; x <= lastTile.x; ++x) {
            uint tile = (y - firstRow) * uint(frame.picture.z) + x;
            mark((layer * uint(frame.band.x) + tile) * wordCount, first, last);
        }
    }
}
