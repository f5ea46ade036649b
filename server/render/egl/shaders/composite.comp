// SPDX-License-Identifier: GPL-3.0-or-later
// One invocation a pixel: walks the slabs that hold points or volume, front to back, and mixes them (docs/PICTURE.md;
// docs/RENDERING.md says how). Compiled with LAYERS, WORDS, VOLUME (0: the tiles hold none), EXACT (0: for a picture
// that moves). Conditions are few inside the loops: a software rasteriser runs both sides of each.
#include "frame.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler3D volumes[layerCount];             // scaled log density
layout(binding = 8) uniform samplerBuffer transfers[layerCount];       // integrals over t of (sigma * color, sigma)
layout(std430, binding = 0) readonly buffer Masks { uint masks[]; };
layout(std430, binding = 1) readonly buffer Offsets { uint offsets[]; };
layout(std430, binding = 2) readonly buffer Cells { uint cells[]; };
layout(std430, binding = 5) readonly buffer VolumeMasks { uint volumeMasks[]; };
layout(std430, binding = 7) writeonly buffer Pixels { uint pixels[]; };   // row by row from the band's first

layout(std430, binding = 8) readonly buffer Tiles { uint tiles[]; };   // to be drawn

layout(location = 0) uniform uint firstTile;   // of this dispatch, in `tiles`
layout(location = 1) uniform uvec2 pass;   // cells [x, x + y) are present; pixels that start there are drawn

const float opaque = 5e-5;      // a transmittance that no 8-bit picture shows
const float fade = 0.125;       // LogDensity::fade
const float tableCells = 4096.0;
const float tableScale = tableCells / (1.0 + fade);
const float narrowest = 1.0 / 64.0;   // a slab's share that points are spread over at least

vec3 light = vec3(0.0);
float transmittance = 1.0;

// The pixel's ray through each layer's box, in slabs.
vec3 entry[LAYERS], advance[LAYERS];
float enters[LAYERS], leaves[LAYERS], unitLength[LAYERS];
// Scaled log density at the front of the current stretch, and the transfer integral up to it.
float frontT[LAYERS];
vec4 frontIntegral[LAYERS];
float sampledTo = -1.0;   // where the front was sampled
// The points of each layer in the current slab: spread evenly between two depths, with so much optical depth a slab.
float pointsFrom[LAYERS], pointsTo[LAYERS], pointsDensity[LAYERS];
uint nextCell[LAYERS];

// `matter`: optical depth times color; optical depth.
void gather(vec4 matter) {
    float passed = exp(-matter.w);
    float share = matter.w < 1e-3 ? 1.0 - 0.5 * matter.w : (1.0 - passed) / matter.w;
    light += transmittance * share * matter.rgb;
    transmittance *= passed;
}

#if VOLUME
vec4 integralTo(uint l, float t, out vec4 slope) {
    float x = clamp((t + fade) * tableScale, 0.0, tableCells);
    float cell = min(floor(x), tableCells - 1.0);
    vec4 low = texelFetch(transfers[l], int(cell));
    vec4 high = texelFetch(transfers[l], int(cell) + 1);
    slope = (high - low) * tableScale;
    return mix(low, high, x - cell);
}

float volumeAt(uint l, float slab) {
    return textureLod(volumes[l], entry[l] + slab * advance[l], 0.0).r;
}

// The mean of the transfer function over a stretch in which t goes evenly from one value to another.
vec4 meanBetween(float t, vec4 integral, float t2, vec4 integral2, vec4 slope) {
    float change = t2 - t;
    return abs(change) > 1.0 / tableCells ? (integral2 - integral) / change : slope;
}

// Mean of (extinction * color, extinction) over a stretch of the ray; its front was sampled before.
vec4 volumeBetween(uint l, float from, float to) {
    vec4 slope;
    float middleT = volumeAt(l, 0.5 * (from + to));
    vec4 middle = integralTo(l, middleT, slope);
#if EXACT
    // The stretch lies between two planes of cell centres, so that t is smooth in it: the means over its halves and
    // over the whole, each with t taken as linear, are extrapolated to the fourth order (Romberg).
    vec4 unused;
    float backT = volumeAt(l, to);
    vec4 back = integralTo(l, backT, unused);
    vec4 whole = meanBetween(frontT[l], frontIntegral[l], backT, back, slope);
    vec4 halves = meanBetween(frontT[l], frontIntegral[l], middleT, middle, slope) +
                  meanBetween(middleT, middle, backT, back, slope);
    frontT[l] = backT;
    frontIntegral[l] = back;
    return max((2.0 * halves - whole) * (1.0 / 3.0), vec4(0.0));
#else
    return max(slope, vec4(0.0));
#endif
}

// How far from `slab` the ray next crosses a plane of cell centres, where t has a kink.
float nextKink(uint l, float slab) {
    vec3 speed = advance[l] * frame.layers[l].scale.y;
    vec3 place = (entry[l] + slab * advance[l]) * frame.layers[l].scale.y - 0.5;
    vec3 way = sign(speed);
    // A crossing less than a thousandth of a cell ahead counts as passed, or rounding would find it again.
    vec3 plane = floor(place * way + 1.001) * way;
    vec3 distance = (plane - place) / mix(speed, vec3(1e-30), lessThan(abs(speed), vec3(1e-20)));
    distance = mix(distance, vec3(1e30), lessThan(abs(speed), vec3(1e-20)));
    return min(distance.x, min(distance.y, distance.z));
}
#endif

// Reads the points of a layer in this slab. n points scattered evenly over a slab span (n - 1) / (n + 1) of it: so far
// around their mean depth they are spread; a single one stays where it is.
void readPoints(uint l, float slab, bool present) {
    pointsDensity[l] = 0.0;
    pointsFrom[l] = pointsTo[l] = -1.0;
    if (!present) return;
    float weight = float(cells[2u * nextCell[l]]);
    float moment = float(cells[2u * nextCell[l] + 1u]);
    ++nextCell[l];
    float count = weight * frame.layers[l].scale.x;
    float spread = max((count - 1.0) / (count + 1.0), narrowest);
    float middle = moment / max(weight, 1.0);
    float from = clamp(middle - 0.5 * spread, 0.0, 1.0 - narrowest);
    float to = min(max(middle + 0.5 * spread, from + narrowest), 1.0);
    pointsFrom[l] = slab + from;
    pointsTo[l] = slab + to;
    pointsDensity[l] = count * frame.layers[l].point.w / (pointsTo[l] - pointsFrom[l]);
}

// The nearest depth behind `at` where something begins or ends; at most `end`.
float nextCut(float at, float end, float stretch, bool volume[LAYERS]) {
    float next = end;
    for (uint l = 0u; l < layerCount; ++l) {
        next = min(next, pointsFrom[l] > at ? pointsFrom[l] : end);
        next = min(next, pointsTo[l] > at ? pointsTo[l] : end);
#if VOLUME
        next = min(next, enters[l] > at ? enters[l] : end);
        next = min(next, leaves[l] > at ? leaves[l] : end);
#if EXACT
        next = min(next, volume[l] ? at + nextKink(l, at) : end);
#endif
#endif
    }
#if VOLUME
    next = min(next, at + stretch);
#endif
    return next;
}

// Walks through one slab, or several without points, from cut to cut.
void gatherSlabs(float at, float end, bool volume[LAYERS], float stretch) {
    while (at < end && transmittance > opaque) {
        float next = nextCut(at, end, stretch, volume);
#if VOLUME && EXACT
        // After a gap the front must be sampled first: by a stretch of no length.
        next = sampledTo == at ? next : at;
        sampledTo = next;
#endif
        vec4 matter = vec4(0.0);
        for (uint l = 0u; l < layerCount; ++l) {
            bool points = pointsFrom[l] <= at && pointsTo[l] > at;
            matter += (points ? pointsDensity[l] : 0.0) * vec4(frame.layers[l].point.rgb, 1.0);
#if VOLUME
            bool inside = volume[l] && enters[l] <= at && leaves[l] > at;
            matter += volumeBetween(l, at, next) * (inside ? unitLength[l] : 0.0);
#endif
        }
        gather(matter * (next - at));
        at = next;
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
    return length(advance[l]) * frame.layers[l].scale.y * frame.window.z * (EXACT == 1 ? 0.5 : 1.0);
}

void walk(uint tile, uint pixel, vec2 at) {
    float stretches = 1e-3;
    for (uint l = 0u; l < layerCount; ++l) {
        stretches = max(stretches, aim(l, at));
        nextCell[l] = offsets[pixel * layerCount + l] - pass.x;
    }
    float stretch = 1.0 / min(stretches, 64.0);
    uint tileCount = uint(frame.band.x);
    for (uint word = 0u; word < wordCount; ++word) {
        uint volumeBits[LAYERS], pointBits[LAYERS];
        uint bits = 0u;
        for (uint l = 0u; l < layerCount; ++l) {
            volumeBits[l] = volumeMasks[(l * tileCount + tile) * wordCount + word];
            pointBits[l] = masks[(l * tileCount * 64u + pixel) * wordCount + word];
            bits |= volumeBits[l] | pointBits[l];
        }
        while (bits != 0u && transmittance > opaque) {
            int first = findLSB(bits);
            uint bit = 1u << first;
            // Slabs from here on without points and with volume of the same layers are walked in one go.
            uint alike = 0xffffffffu;
            bool volume[LAYERS];
            for (uint l = 0u; l < layerCount; ++l) {
                readPoints(l, float(word * 32u + uint(first)), (pointBits[l] & bit) != 0u);
                volume[l] = (volumeBits[l] & bit) != 0u;
                alike &= (volume[l] ? volumeBits[l] : ~volumeBits[l]) & ~pointBits[l];
            }
            int past = findLSB(~alike & ~(bit - 1u));   // -1: none in this word
            int end = max(past < 0 ? 32 : past, first + 1);
            gatherSlabs(float(word * 32u) + float(first), float(word * 32u) + float(end), volume, stretch);
            bits &= end == 32 ? 0u : ~0u << end;
        }
    }
}

vec3 encoded(vec3 linear) {   // IEC 61966-2-1
    vec3 curved = 1.055 * pow(max(linear, vec3(1e-9)), vec3(1.0 / 2.4)) - 0.055;
    return mix(curved, 12.92 * linear, lessThanEqual(linear, vec3(0.0031308)));
}

void main() {
    uint tile = tiles[firstTile + gl_WorkGroupID.x];
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
    if (transmittance == 1.0) {   // the very same value as in tiles that are left blank
        if (frame.band.z != 0) {
            pixels[2u * number] = frame.blank.x;
            pixels[2u * number + 1u] = frame.blank.y;
        } else {
            pixels[number] = frame.blank.x;
        }
    } else if (frame.band.z != 0) {
        pixels[2u * number] = packHalf2x16(light.rg);
        pixels[2u * number + 1u] = packHalf2x16(vec2(light.b, 1.0));
    } else {
        pixels[number] = packUnorm4x8(vec4(encoded(clamp(light, 0.0, 1.0)), 1.0));
    }
}
