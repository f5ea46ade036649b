// SPDX-License-Identifier: GPL-3.0-or-later
// One invocation a pixel: walks the slabs that hold points or volume, front to back, and mixes them (docs/PICTURE.md;
// docs/RENDERING.md says how). Compiled with LAYERS, HYBRIDS, SECTIONS (2: several), POINTS, VOLUME and DOTS (0: the
// tiles hold none), EXACT (0: for a picture that moves). Conditions are few inside the loops: a software rasteriser runs
// both sides of each.
#include "frame.glsl"
#include "pixel.glsl"
#include "ray.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
#if LAYERS > HYBRIDS
layout(binding = 0) uniform sampler3D volumes[LAYERS - HYBRIDS];           // scaled log density
#endif
layout(binding = 8) uniform samplerBuffer transfers;                       // integrals of (sigma * color, sigma) over t: [layer][cell]
layout(binding = 9) uniform usamplerBuffer masks;                         // slab bits, first cell: [layer][pixel][word]
layout(binding = 10) uniform usamplerBuffer cells;                         // weight, moment
layout(binding = 11) uniform usamplerBuffer volumeMasks;                   // slab bits: [layer][tile][word]
#if DOTS
layout(binding = 12) uniform samplerBuffer dotData;                        // x, y, reach, slab; color, opacity
layout(binding = 13) uniform usamplerBuffer dotLists;                      // of each tile: where its list begins; dots
#endif
layout(std430, binding = 1) readonly buffer Offsets { uint offsets[]; };   // of each pixel: its first cell

layout(std430, binding = 6) readonly buffer Tiles { uint tiles[]; };   // to be drawn

layout(location = 0) uniform uint firstTile;   // of this dispatch, in `tiles`
layout(location = 1) uniform uvec2 pass;   // cells [x, x + y) are present; pixels that start there are drawn

const float fade = 0.125;       // LogDensity::fade
const float tableCells = 4095.0;
const float tableScale = tableCells / (1.0 + fade);
const float narrowest = 1.0 / 64.0;   // a slab's share that points are spread over at least
const float densest = 2.0;   // optical depth of a stretch, about, whose color is taken to change evenly
// Scaled log density at the front of the current stretch, the transfer integral up to it, and extinction there.
float frontT[LAYERS], frontExtinction[LAYERS];
vec4 frontIntegral[LAYERS];
float sampledTo = -1.0;   // where the front was sampled
float stretch[LAYERS];    // slabs, of a layer of particles: the most that is gone at once where its volume is
// The points of each layer in the current slab: several are spread evenly between two depths, with so much optical
// depth a slab; a single one (from = to) has its optical depth at one place.
float pointsFrom[LAYERS], pointsTo[LAYERS], pointsDensity[LAYERS], pointTau[LAYERS];
// The slabs of the current word that are still ahead.
uint volumeBits[LAYERS], pointBits[LAYERS], nextCell[LAYERS];

#if DOTS
const float beyond = 1e30;   // slabs; of a pixel without further dots
int dotAt, dotEnd;           // in dotLists
float dotDepth = beyond;     // of the pixel's next dot
vec4 dotInk;                 // its color; its opacity in this pixel
vec2 pixelCentre;

// Goes on to the next dot that covers the pixel, from dotAt on.
void findDot() {
    dotDepth = beyond;
    while (dotAt < dotEnd && dotDepth == beyond) {
        int index = 2 * int(texelFetch(dotLists, dotAt).x);
        vec4 place = texelFetch(dotData, index);
        dotInk = texelFetch(dotData, index + 1);
        dotInk.a *= clamp(place.z - distance(pixelCentre, place.xy), 0.0, 1.0);
        dotDepth = dotInk.a > 0.0 ? place.w : beyond;
        ++dotAt;
    }
}

// The dots up to a depth.
void passDots(float to) {
    while (dotDepth <= to) {
        light += transmittance * dotInk.a * dotInk.rgb;
        transmittance *= 1.0 - dotInk.a;
        findDot();
    }
}

void aimDots(uint tile, vec2 centre) {
    pixelCentre = centre;
    dotAt = int(texelFetch(dotLists, int(tile)).x);
    dotEnd = int(texelFetch(dotLists, int(tile) + 1).x);
    findDot();
}
#endif

#if HYBRIDS
#include "hybrid.glsl"
#endif

#if VOLUME && LAYERS > HYBRIDS
vec4 integralTo(uint l, float t, out vec4 slope) {
    float x = clamp((t + fade) * tableScale, 0.0, tableCells);
    float cell = min(floor(x), tableCells - 1.0);
    int index = int(l) * (int(tableCells) + 1) + int(cell);
    vec4 low = texelFetch(transfers, index);
    vec4 high = texelFetch(transfers, index + 1);
    slope = (high - low) * tableScale;
    return mix(low, high, x - cell);
}

float volumeAt(uint l, float slab) {
    vec3 place = entry[l] + slab * advance[l];
#if HYBRIDS == 0
    return textureLod(volumes[l], place, 0.0).r;
#else
    // By constant numbers, see wordAt() of hybrid.glsl.
    float t = 0.0;
#define VOLUME_OF(i) if (l == uint(i)) t = textureLod(volumes[i], place, 0.0).r;
    VOLUME_OF(0)
#if LAYERS - HYBRIDS > 1
    VOLUME_OF(1)
#endif
#if LAYERS - HYBRIDS > 2
    VOLUME_OF(2)
#endif
#if LAYERS - HYBRIDS > 3
    VOLUME_OF(3)
#endif
#if LAYERS - HYBRIDS > 4
    VOLUME_OF(4)
#endif
#if LAYERS - HYBRIDS > 5
    VOLUME_OF(5)
#endif
#if LAYERS - HYBRIDS > 6
    VOLUME_OF(6)
#endif
    return t;
#endif
}

// The mean of the transfer function over a stretch in which t goes evenly from one value to another.
vec4 meanBetween(float t, vec4 integral, float t2, vec4 integral2, vec4 slope) {
    float change = t2 - t;
    return abs(change) > 1.0 / tableCells ? (integral2 - integral) / change : slope;
}

// Mean of (extinction * color, extinction) over a stretch of the ray; its front was sampled before. `change`: of the
// first, from front to back.
vec4 volumeBetween(uint l, float from, float to, out vec3 change) {
    vec4 slope;
    change = vec3(0.0);
    float middleT = volumeAt(l, 0.5 * (from + to));
    vec4 middle = integralTo(l, middleT, slope);
#if EXACT
    // The stretch lies between two planes of cell centres, so that t is smooth in it: the means over its halves and
    // over the whole, each with t taken as linear, are extrapolated to the fourth order (Romberg).
    vec4 backSlope;
    float backT = volumeAt(l, to);
    vec4 back = integralTo(l, backT, backSlope);
    vec4 whole = meanBetween(frontT[l], frontIntegral[l], backT, back, slope);
    vec4 near = meanBetween(frontT[l], frontIntegral[l], middleT, middle, slope);
    vec4 far = meanBetween(middleT, middle, backT, back, slope);
    frontT[l] = backT;
    frontIntegral[l] = back;
    frontExtinction[l] = backSlope.w;
    vec4 mean = max((2.0 * (near + far) - whole) * (1.0 / 3.0), vec4(0.0));
    // Of the colors, whatever extinction does.
    bool both = min(near.w, far.w) > 0.0;
    change = both ? 2.0 * mean.w * (far.rgb / far.w - near.rgb / near.w) : vec3(0.0);
    return mean;
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
    pointsDensity[l] = pointTau[l] = 0.0;
    pointsFrom[l] = pointsTo[l] = -1.0;
    if (!present) return;
    vec2 cell = vec2(texelFetch(cells, int(nextCell[l])).xy);
    ++nextCell[l];
    float weight = cell.x;
    float moment = cell.y;
    float count = weight * frame.layers[l].scale.x;
    float tau = count * frame.layers[l].point.w;
    float middle = clamp(moment / max(weight, 1.0), narrowest, 1.0);
    float spread = count < 1.5 ? 0.0 : (count - 1.0) / (count + 1.0);
    float from = clamp(middle - 0.5 * spread, 0.0, 1.0);
    float to = clamp(middle + 0.5 * spread, from, 1.0);
    pointsFrom[l] = slab + from;
    pointsTo[l] = slab + to;
    // Where both are the same after rounding, too, the points stand in one place.
    bool one = pointsTo[l] == pointsFrom[l];
    pointsDensity[l] = one ? 0.0 : tau / (pointsTo[l] - pointsFrom[l]);
    pointTau[l] = one ? tau : 0.0;
}

// The nearest depth behind `at` where something begins or ends; at most `end`.
float nextCut(float at, float end, bool volume[LAYERS]) {
    float next = end;
    for (uint l = 0u; l < layerCount; ++l) {
#if POINTS
        next = min(next, pointsFrom[l] > at ? pointsFrom[l] : end);
        next = min(next, pointsTo[l] > at ? pointsTo[l] : end);
#endif
#if VOLUME
        next = min(next, enters[l] > at ? enters[l] : end);
        next = min(next, leaves[l] > at ? leaves[l] : end);
        bool inside = volume[l] && enters[l] <= at && leaves[l] > at;
#if HYBRIDS
        if (l >= plots) {
            float leaving = enterBrick(l, at);
            // Where there is something to mix with, only as far as the value is taken as linear.
            leaving = brickSeen[l - plots] && layerCount > 1u ? min(leaving, brickStep[l - plots]) : leaving;
            next = min(next, inside ? at + leaving : end);
            continue;
        }
#endif
#if LAYERS > HYBRIDS
        float most = stretch[l];
#if EXACT
        most = min(most, min(nextKink(l, at), densest / max(frontExtinction[l] * unitLength[l], 1e-20)));
#endif
        next = min(next, inside ? at + most : end);
#endif
#endif
    }
#if DOTS
    next = min(next, dotDepth);
#endif
    // However close the cuts, each step must go on in single precision.
    return min(max(next, at + 1e-4), end);
}

// Where the ray is inside the layer's box, and how far it may go there in one stretch.
void aim(uint l, vec2 at) {
    aimBox(l, at);
#if HYBRIDS
    if (l >= plots) {
        clipWay(l);
        unitLength[l] = hybridLength(l);
        return;
    }
#endif
    unitLength[l] = 2.0 * length(advance[l]);   // layer space is the box scaled to an edge of 2
    float cells = length(advance[l]) * frame.layers[l].scale.y;
    stretch[l] = 1.0 / clamp(cells * frame.window.z * (EXACT == 1 ? 0.5 : 1.0), 1e-3, 64.0);
}

// From one depth to the next cut; returns it.
float gatherStretch(float at, float end, bool volume[LAYERS]) {
    float next = nextCut(at, end, volume);
#if VOLUME && EXACT && LAYERS > HYBRIDS
    // After a gap the front must be sampled first: by a stretch of no length.
    next = sampledTo == at ? next : at;
    sampledTo = next;
#endif
    vec4 matter = vec4(0.0);
    vec3 change = vec3(0.0);
    vec4 single = vec4(0.0);
    for (uint l = 0u; l < layerCount; ++l) {
#if POINTS
        vec4 color = vec4(frame.layers[l].point.rgb, 1.0);
        matter += (pointsFrom[l] <= at && pointsTo[l] > at ? pointsDensity[l] : 0.0) * color;
        // A single point ends the stretch before it.
        single += (pointsFrom[l] > at && pointsFrom[l] <= next ? pointTau[l] : 0.0) * color;
#endif
#if VOLUME
        bool inside = volume[l] && enters[l] <= at && leaves[l] > at;
#if HYBRIDS
        if (l >= plots) {
            matter += hybridBetween(l, at, inside && brickSeen[l - plots] ? next : at);
            continue;
        }
#endif
#if LAYERS > HYBRIDS
        vec3 ownChange;
        float share = inside ? unitLength[l] : 0.0;
        matter += volumeBetween(l, at, next, ownChange) * share;
        change += ownChange * share;
#endif
#endif
    }
    gather(matter * (next - at), change * (next - at));
#if POINTS
    gather(single);
#endif
#if DOTS
    passDots(next);
#endif
    return next;
}

// All layers, in the section.
void aimAll(vec2 at) {
    for (uint l = 0u; l < layerCount; ++l) aim(l, at);
}

void walk(uint tile, uint pixel, vec2 at) {
#if SECTIONS > 1
    uint section = 0u;
    enterSection(0u);
#else
    sectionEnd = float(frame.band.y);
#endif
    aimAll(at);
    uint tileCount = uint(frame.band.x);
    uint word = 0u;
    uint bits = 0u;   // slabs of the current word that are ahead and not blank
    float depth = 0.0;
    float end = 0.0;
    bool volume[LAYERS];
    // One loop and not loops within loops, or neighbouring pixels would wait for each other at the end of each.
    while (transmittance > opaque) {
        if (depth >= end) {
            while (bits == 0u && word < wordCount) {
                for (uint l = 0u; l < layerCount; ++l) {
#if POINTS
                    uvec2 mask = texelFetch(masks, int((l * tileCount * 64u + pixel) * wordCount + word)).xy;
                    pointBits[l] = mask.x;
                    nextCell[l] = mask.y - pass.x;
#else
                    pointBits[l] = 0u;
#endif
                    volumeBits[l] = texelFetch(volumeMasks, int((l * tileCount + tile) * wordCount + word)).x;
                    bits |= pointBits[l] | volumeBits[l];
                }
                ++word;
            }
            if (bits == 0u) break;
            int first = findLSB(bits);
            uint bit = 1u << first;
            depth = float(int(word * 32u) - 32 + first);
#if SECTIONS > 1
            if (depth >= sectionEnd) {
                do enterSection(++section);
                while (depth >= sectionEnd);
                aimAll(at);
                sampledTo = -1.0;
            }
#endif
            // Slabs from here on without points and with volume of the same layers are walked in one go.
            uint alike = 0xffffffffu;
            for (uint l = 0u; l < layerCount; ++l) {
#if POINTS
                readPoints(l, depth, (pointBits[l] & bit) != 0u);
#endif
                volume[l] = (volumeBits[l] & bit) != 0u;
                alike &= (volume[l] ? volumeBits[l] : ~volumeBits[l]) & ~pointBits[l];
            }
            int past = findLSB(~alike & ~(bit - 1u));   // -1: none in this word
            past = max(past < 0 ? 32 : past, first + 1);
#if SECTIONS > 1
            past = min(past, first + int(sectionEnd - depth));
#endif
            end = depth + float(past - first);
            bits &= past == 32 ? 0u : ~0u << past;
#if DOTS
            passDots(depth);
#endif
        }
        depth = gatherStretch(depth, end, volume);
    }
}

void main() {
    uint tile = tiles[firstTile + gl_WorkGroupID.x];
    uvec2 place = uvec2(tile % uint(frame.picture.z), tile / uint(frame.picture.z)) * 8u + gl_LocalInvocationID.xy;
    uint row = place.y + uint(frame.picture.w) * 8u;   // of the picture; place.y is the band's
    uint pixel = tile * 64u + gl_LocalInvocationIndex;
    uvec2 size = uvec2(frame.picture.xy);
    if (place.x >= size.x || row >= size.y) return;
#if POINTS
    if (offsets[pixel] - pass.x >= pass.y) return;
#endif
    vec2 ndc = (vec2(place.x, row) + 0.5) / vec2(size) * 2.0 - 1.0;
#if DOTS
    aimDots(tile, vec2(place.x, row) + 0.5);
#endif
    walk(tile, pixel, vec2(ndc.x, -ndc.y) * frame.window.xy);
#if DOTS
    passDots(2.0 * float(frame.band.y));
#endif
    store(place.y * size.x + place.x, light, transmittance);
}
