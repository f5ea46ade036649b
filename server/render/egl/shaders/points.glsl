// SPDX-License-Identifier: GPL-3.0-or-later
// A point's pixels and slab, for points_mark and points_add, which include bends.glsl and define touch(). Both must find
// the very same ones, hence `precise`. Compiled with DISCS (points larger than a pixel), FLAT (depth does not matter),
// SELECTION, WEIGHTS.

layout(local_size_x = 256) in;
layout(binding = 0) uniform usamplerBuffer points;   // place in units of 2^-31 of the box; leaf within the chunk
// SELECTION 1: of each leaf, the point before which it is drawn. 2: the points of the chunk that are drawn.
layout(binding = 1) uniform usamplerBuffer selected;
layout(std430, binding = 3) readonly buffer Blocks { uint blocks[]; };   // of 256 points; SELECTION 0: all drawn

uniform mat4 toScreen;   // from places in units of 2^-31 of the box, relative to `origin`
uniform uvec3 origin;    // so that few digits are lost where the camera is close
uniform uint layer;
uniform float radius;    // DISCS: where coverage reaches 0, in pixels
uniform float nearest;  // FLAT: w below which nothing is seen
uniform uint listed;     // SELECTION 2: how many points there are

#if WEIGHTS
layout(binding = 4) uniform samplerBuffer weights;   // what a point of each leaf of the chunk weighs
#endif
float weighs = 1.0;      // the point

void touch(uint pixel, uint slab, float fraction, float coverage);

void draw(vec2 at, uint slab, float fraction) {
#if DISCS
    int top = frame.picture.w * 8;
    ivec2 first = ivec2(max(ceil(at - radius - 0.5), vec2(0.0, float(top))));
    ivec2 last = ivec2(min(floor(at + radius - 0.5), vec2(frame.picture.x - 1, top + frame.band.w - 1)));
    for (int y = first.y; y <= last.y; ++y) {
        for (int x = first.x; x <= last.x; ++x) {
            precise float coverage = min(radius - distance(vec2(x, y) + 0.5, at), 1.0);
            if (coverage > 0.0) touch(pixelNumber(uint(x), uint(y)), slab, fraction, coverage);
        }
    }
#else
    uvec2 place = uvec2(ivec2(at));
    touch(pixelNumber(place.x, place.y), slab, fraction, 1.0);
#endif
}

void main() {
#if SELECTION == 2
    uint entry = gl_GlobalInvocationID.x;
    if (entry >= listed) return;
    uvec4 point = texelFetch(points, int(texelFetch(selected, int(entry)).x));
#else
    uint index = blocks[gl_WorkGroupID.x] * 256u + gl_LocalInvocationID.x;
    uvec4 point = texelFetch(points, int(index));
#if SELECTION == 1
    if (index >= texelFetch(selected, int(point.w)).x) return;
#endif
#endif
#if WEIGHTS
    weighs = texelFetch(weights, int(point.w)).x;
#endif
    vec3 place = vec3(ivec3(point.xyz - origin));
    precise vec4 screen = toScreen[0] * place.x + toScreen[1] * place.y + toScreen[2] * place.z + toScreen[3];
    precise vec2 at = screen.xy * (1.0 / screen.w);
#if DISCS
    vec2 margin = vec2(radius);
    bool seen = all(greaterThanEqual(at, -margin)) && all(lessThan(at, vec2(frame.picture.xy) + margin));
#else
    // What lies far outside becomes the least integer, and that, taken as unsigned, lies outside too.
    uvec2 pixel = uvec2(ivec2(floor(at)) - ivec2(0, frame.picture.w * 8));
    bool seen = pixel.x < uint(frame.picture.x) && pixel.y < uint(frame.band.w);
#endif
#if FLAT
    if (!seen || screen.w <= nearest) return;
    draw(at, 0u, 0.0);
#else
    if (!seen || screen.w <= 0.0 || screen.z < -0.001) return;
    precise float depth = bent(screen.z);
    int slab = int(clamp(depth, 0.0, bendShape.z - 0.5));
    draw(at, uint(slab) + uint(bendShape.y), clamp(depth - float(slab), 0.0, 1.0));
#endif
}
