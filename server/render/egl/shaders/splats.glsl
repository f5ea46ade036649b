// SPDX-License-Identifier: GPL-3.0-or-later
// A point of a hybrid volume on the screen (docs/PICTURE.md): its pixels, its opacity in each, its slab and its color,
// for points_mark and splats_add, which define touch(). Both must find the very same pixels, hence `precise`. Compiled
// with LAYERS, WORDS (of slab bits a pixel) and SHAPE: 0 squares, 1 discs, 2 Gaussians.

layout(local_size_x = 256) in;
layout(binding = 0) uniform usamplerBuffer points;   // x | y << 16; z | value << 16 | error << 24; normal
layout(binding = 1) uniform samplerBuffer look;      // [value | error << 8] opacity; [value] color; [normal] shade

uniform mat4 toScreen;     // from samples of the error grid
uniform uint layer;
uniform uvec2 range;       // points of numbers [x, y) among those that are drawn
uniform uvec2 stride;      // of x points that follow each other one is drawn (HybridPlan::point); of y in all
uniform float spacing;     // of points, pixels at w = 1
uniform float size;        // over spacing
uniform float opacity;     // times a point's own
uniform vec3 gridSize;     // samples of the error grid
uniform int clips;
uniform vec4 clip[12];     // in the box: dot(xyz, place) >= w is drawn

const float pi = 3.14159265358979;
const float least = 1e-5;   // opacity: a hundred such points show in no picture of 8 bits
const int colorsBegin = 65536, shadesBegin = colorsBegin + 3 * 256;

vec3 splatColor;

void touch(uint pixel, uint slab, float fraction, float opacity);
void count();   // a point that is drawn

// `at`: pixels. `p`, `w`: spacing and size in pixels; `a`: the point's opacity.
void draw(vec2 at, float p, float w, float a, uint slab, float fraction) {
#if SHAPE == 0
    precise float edge = ceil(w);
    precise vec2 begin = ceil(at - 0.5 * edge - 0.5);
    precise vec2 end = ceil(at + 0.5 * edge - 0.5);
    float most = min(1.0, p * p / (edge * edge));
#elif SHAPE == 1
    precise float reach = sqrt(max(w * w / pi, 1.0 / 3.0) - 1.0 / 12.0) + 0.5;
    float most = min(1.0, p * p / (w * w)) * min(1.0, 3.0 * w * w / pi);
#else
    precise float deviation = 0.5 * max(w, 1.0);
    precise float reach = 3.0 * deviation;
    float most = p * p / (2.0 * pi * deviation * deviation);
#endif
#if SHAPE != 0
    precise vec2 begin = ceil(at - reach - 0.5);
    precise vec2 end = floor(at + reach - 0.5) + 1.0;
#endif
    int top = frame.picture.w * 8;
    ivec2 first = ivec2(max(begin, vec2(0.0, float(top))));
    ivec2 last = ivec2(min(end, vec2(frame.picture.x, top + frame.band.w)));
    for (int y = first.y; y < last.y; ++y) {
        for (int x = first.x; x < last.x; ++x) {
            uint pixel = pixelNumber(uint(x), uint(y));
#if SHAPE == 0
            touch(pixel, slab, fraction, a * most);
#else
            precise float away = distance(vec2(x, y) + 0.5, at);
            if (away >= reach) continue;
#if SHAPE == 1
            touch(pixel, slab, fraction, a * most * min(reach - away, 1.0));
#else
            touch(pixel, slab, fraction, a * min(1.0, most * exp(-0.5 * away * away / (deviation * deviation))));
#endif
#endif
        }
    }
}

void main() {
    uint index = range.x + gl_GlobalInvocationID.x;
    if (index >= range.y) return;
    index = min(index * stride.x + (index * 2654435761u >> 16) % stride.x, stride.y - 1u);
    uvec3 point = texelFetch(points, int(index)).xyz;
    uint value = (point.y >> 16) & 255u;
    float a = opacity * texelFetch(look, int(value | (point.y >> 24) << 8)).x;
    if (a < least) return;
    vec3 place = vec3(point.x & 0xffffu, point.x >> 16, point.y & 0xffffu);
    for (int i = 0; i < clips; ++i) {
        if (dot(clip[i].xyz, (place + 0.5) / gridSize) < clip[i].w) return;
    }
    precise vec4 screen = toScreen[0] * place.x + toScreen[1] * place.y + toScreen[2] * place.z + toScreen[3];
    if (screen.w <= 0.0 || screen.z < -0.001) return;
    precise vec2 at = screen.xy * (1.0 / screen.w);
    precise float p = spacing / screen.w;
    precise float w = size * p;
    vec2 margin = vec2(1.5 * max(w, 1.0) + 1.0);
    if (any(lessThan(at, -margin)) || any(greaterThan(at, vec2(frame.picture.xy) + margin))) return;
    count();
    int shade = shadesBegin + 2 * int(point.z);
    int color = colorsBegin + 3 * int(value);
    splatColor = vec3(texelFetch(look, color).x, texelFetch(look, color + 1).x, texelFetch(look, color + 2).x) *
                     texelFetch(look, shade).x + texelFetch(look, shade + 1).x;
    int slab = int(clamp(screen.z, 0.0, float(frame.band.y) - 0.5));
    draw(at, p, w, a, uint(slab), clamp(screen.z - float(slab), 0.0, 1.0));
}
