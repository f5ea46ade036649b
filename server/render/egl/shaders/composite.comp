// SPDX-License-Identifier: GPL-3.0-or-later
// One invocation a pixel: walks the slabs that hold points or volume, front to back, and mixes them (docs/PICTURE.md;
// docs/RENDERING.md says how). Compiled with LAYERS, WORDS.
#include "frame.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler3D volumes[layerCount];             // scaled log density
layout(binding = 8) uniform samplerBuffer transfers[layerCount];       // integrals over t of (sigma * color, sigma)
layout(std430, binding = 0) readonly buffer Masks { uint masks[]; };
layout(std430, binding = 1) readonly buffer Offsets { uint offsets[]; };
layout(std430, binding = 2) readonly buffer Cells { uint cells[]; };
layout(std430, binding = 5) readonly buffer VolumeMasks { uint volumeMasks[]; };
layout(std430, binding = 7) writeonly buffer Pixels { uint pixels[]; };   // row by row from the band's first

layout(location = 0) uniform uint firstTile;
layout(location = 1) uniform uvec2 pass;   // cells [x, x + y) are present; pixels that start there are drawn

const float opaque = 5e-5;      // a transmittance that no 8-bit picture shows
const float fade = 0.125;       // LogDensity::fade
const float tableCells = 4096.0;

vec3 light = vec3(0.0);
float transmittance = 1.0;

// The pixel's ray through each layer's box, in slabs.
vec3 entry[layerCount], advance[layerCount];
float enters[layerCount], leaves[layerCount], unitLength[layerCount];
// The last sample along the ray: where it was (negative: none), t there, and the transfer integral up to t.
float sampledAt[layerCount], sampledT[layerCount];
vec4 sampledIntegral[layerCount];
// The points of each layer in the current slab: spread evenly from `pointsFrom` to `pointsTo` (fractions of the slab).
float pointsFrom[layerCount], pointsTo[layerCount], pointsTau[layerCount];
uint nextCell[layerCount];

// `matter`: optical depth times color; optical depth.
void gather(vec4 matter) {
    float passed = exp(-matter.w);
    float share = matter.w < 1e-3 ? 1.0 - 0.5 * matter.w : (1.0 - passed) / matter.w;
    light += transmittance * share * matter.rgb;
    transmittance *= passed;
}

vec4 integralTo(uint l, float t, out vec4 slope) {
    float x = clamp((t + fade) * (tableCells / (1.0 + fade)), 0.0, tableCells);
    float cell = min(floor(x), tableCells - 1.0);
    vec4 low = texelFetch(transfers[l], int(cell));
    vec4 high = texelFetch(transfers[l], int(cell) + 1);
    slope = (high - low) * (tableCells / (1.0 + fade));
    return mix(low, high, x - cell);
}

vec4 sampleVolume(uint l, float slab) {   // returns the slope of the transfer integral there
    vec4 slope;
    sampledAt[l] = slab;
    sampledT[l] = textureLod(volumes[l], entry[l] + slab * advance[l], 0.0).r;
    sampledIntegral[l] = integralTo(l, sampledT[l], slope);
    return slope;
}

// The volume of a layer between two depths: t taken as linear between the samples at both ends, so that the mean of
// any transfer function over the stretch is a difference of its integral.
vec4 volumeBetween(uint l, float from, float to) {
    from = clamp(from, enters[l], leaves[l]);
    to = clamp(to, enters[l], leaves[l]);
    if (!(to > from)) return vec4(0.0);
    if (sampledAt[l] != from) sampleVolume(l, from);
    float t = sampledT[l];
    vec4 integral = sampledIntegral[l];
    vec4 mean = sampleVolume(l, to);
    float change = sampledT[l] - t;
    if (abs(change) > 1.0 / tableCells) mean = (sampledIntegral[l] - integral) / change;
    return max(mean, vec4(0.0)) * ((to - from) * unitLength[l]);
}

// Reads the points of a layer in this slab. n points scattered evenly over a slab span (n - 1) / (n + 1) of it: so far
// around their mean depth they are spread; a single one stays where it is.
void readPoints(uint l, bool present) {
    pointsTau[l] = 0.0;
    pointsFrom[l] = pointsTo[l] = 2.0;
    if (!present) return;
    float weight = float(cells[2u * nextCell[l]]);
    float moment = float(cells[2u * nextCell[l] + 1u]);
    ++nextCell[l];
    if (weight == 0.0) return;
    float count = weight * frame.layers[l].scale.x;
    float spread = max((count - 1.0) / (count + 1.0), 1.0 / 64.0);
    float middle = moment / weight;
    pointsTau[l] = count * frame.layers[l].point.w;
    pointsFrom[l] = clamp(middle - 0.5 * spread, 0.0, 1.0 - 1.0 / 64.0);
    pointsTo[l] = min(max(middle + 0.5 * spread, pointsFrom[l] + 1.0 / 64.0), 1.0);
}

// A stretch of the slab of even volume, cut where the points of a layer begin and end.
void gatherStretch(float from, float to, vec4 volume) {
    float at = from;
    for (uint cut = 0u; cut < 2u * layerCount + 1u && at < to; ++cut) {
        float next = to;
        for (uint l = 0u; l < layerCount; ++l) {
            if (pointsFrom[l] > at) next = min(next, pointsFrom[l]);
            if (pointsTo[l] > at) next = min(next, pointsTo[l]);
        }
        vec4 matter = volume * ((next - at) / (to - from));
        for (uint l = 0u; l < layerCount; ++l) {
            if (pointsFrom[l] <= at && pointsTo[l] > at) {
                float tau = pointsTau[l] * (next - at) / (pointsTo[l] - pointsFrom[l]);
                matter += tau * vec4(frame.layers[l].point.rgb, 1.0);
            }
        }
        gather(matter);
        at = next;
    }
}

void gatherSlab(uint slab, uint volumeBits[layerCount], uint pointBits[layerCount], float stretches) {
    uint bit = 1u << (slab & 31u);
    bool anyVolume = false;
    bool anyPoints = false;
    for (uint l = 0u; l < layerCount; ++l) {
        readPoints(l, (pointBits[l] & bit) != 0u);
        anyPoints = anyPoints || pointsTau[l] > 0.0;
        anyVolume = anyVolume || (volumeBits[l] & bit) != 0u;
    }
    if (!anyVolume) {
#if LAYERS > 1
        gatherStretch(0.0, 1.0, vec4(0.0));
#else
        gather(pointsTau[0] * vec4(frame.layers[0].point.rgb, 1.0));
#endif
        return;
    }
    for (float i = 0.0; i < stretches; ++i) {
        float from = float(slab) + i / stretches;
        float to = float(slab) + (i + 1.0) / stretches;
        vec4 volume = vec4(0.0);
        for (uint l = 0u; l < layerCount; ++l) {
            if ((volumeBits[l] & bit) != 0u) volume += volumeBetween(l, from, to);
        }
        if (anyPoints) {
            gatherStretch(i / stretches, (i + 1.0) / stretches, volume);
        } else {
            gather(volume);
        }
    }
}

// Where the ray is inside the layer's box, and into how many stretches its slabs are to be cut. At least 1.
float aim(uint l, vec2 at) {
    entry[l] = frame.layers[l].entry[0].xyz + at.x * frame.layers[l].entry[1].xyz + at.y * frame.layers[l].entry[2].xyz;
    advance[l] = frame.layers[l].advance[0].xyz + at.x * frame.layers[l].advance[1].xyz +
                 at.y * frame.layers[l].advance[2].xyz;
    vec3 safe = mix(advance[l], vec3(1e-30), lessThan(abs(advance[l]), vec3(1e-30)));
    vec3 a = -entry[l] / safe;
    vec3 b = (vec3(1.0) - entry[l]) / safe;
    vec3 low = min(a, b);
    vec3 high = max(a, b);
    enters[l] = max(max(low.x, low.y), max(low.z, 0.0));
    leaves[l] = min(min(high.x, high.y), min(high.z, float(frame.band.y)));
    unitLength[l] = 2.0 * length(advance[l]);   // layer space is the box scaled to an edge of 2
    sampledAt[l] = -1.0;
    return length(advance[l]) * frame.layers[l].scale.y * frame.window.z;
}

void walk(uint tile, uint pixel, vec2 at) {
    float stretches = 1.0;
    for (uint l = 0u; l < layerCount; ++l) {
        stretches = max(stretches, aim(l, at));
        nextCell[l] = offsets[pixel * layerCount + l] - pass.x;
    }
    stretches = min(ceil(stretches), 64.0);
    uint tiles = uint(frame.band.x);
    for (uint word = 0u; word < wordCount; ++word) {
        uint volumeBits[layerCount], pointBits[layerCount];
        uint bits = 0u;
        for (uint l = 0u; l < layerCount; ++l) {
            volumeBits[l] = volumeMasks[(l * tiles + tile) * wordCount + word];
            pointBits[l] = masks[(l * tiles * 64u + pixel) * wordCount + word];
            bits |= volumeBits[l] | pointBits[l];
        }
        while (bits != 0u && transmittance > opaque) {
            int next = findLSB(bits);
            bits &= bits - 1u;
            gatherSlab(word * 32u + uint(next), volumeBits, pointBits, stretches);
        }
    }
}

vec3 encoded(vec3 linear) {   // IEC 61966-2-1
    vec3 curved = 1.055 * pow(max(linear, vec3(1e-9)), vec3(1.0 / 2.4)) - 0.055;
    return mix(curved, 12.92 * linear, lessThanEqual(linear, vec3(0.0031308)));
}

void main() {
    uint tile = firstTile + gl_WorkGroupID.x;
    uint tileColumn = tile % uint(frame.picture.z);
    uint tileRow = tile / uint(frame.picture.z);
    uvec2 local = gl_LocalInvocationID.xy;
    uvec2 place = uvec2(tileColumn * 8u + local.x, tileRow * 8u + local.y);   // within the band
    uint pixel = tile * 64u + local.y * 8u + local.x;
    uvec2 size = uvec2(frame.picture.xy);
    uint pictureRow = place.y + uint(frame.picture.w) * 8u;
    if (place.x >= size.x || pictureRow >= size.y || offsets[pixel * layerCount] - pass.x >= pass.y) return;
    vec2 ndc = (vec2(place.x, pictureRow) + 0.5) / vec2(size) * 2.0 - 1.0;
    walk(tile, pixel, vec2(ndc.x, -ndc.y) * frame.window.xy);
    light += transmittance * frame.background.rgb;
    uint number = place.y * size.x + place.x;
    if (frame.band.z != 0) {
        pixels[2u * number] = packHalf2x16(light.rg);
        pixels[2u * number + 1u] = packHalf2x16(vec2(light.b, 1.0));
    } else {
        pixels[number] = packUnorm4x8(vec4(encoded(clamp(light, 0.0, 1.0)), 1.0));
    }
}
