// SPDX-License-Identifier: GPL-3.0-or-later
// One invocation a pixel: walks the slabs that hold points or volume, front to back, and mixes them (docs/PICTURE.md;
// docs/RENDERING.md says how). Compiled with LAYERS, GRIDS, SECTIONS (2: several), POINTS, VOLUME and DOTS (0: the
// tiles hold none), EXACT (0: for a picture that moves), COLORS. Conditions are few inside the loops: a software rasteriser runs
// both sides of each.
#include "frame.glsl"
#include "pixel.glsl"
#include "ray.glsl"
#include "matter.glsl"
#include "colors.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 9) uniform usamplerBuffer masks;                         // slab bits, first cell: [layer][pixel][word]
layout(binding = 10) uniform usamplerBuffer cells;                         // weight, moment
layout(binding = 11) uniform usamplerBuffer volumeMasks;                   // slab bits: [layer][tile][word]
layout(std430, binding = 1) readonly buffer Offsets { uint offsets[]; };   // each pixel's first cell

layout(std430, binding = 6) readonly buffer Tiles { uint tiles[]; };   // to be drawn

layout(location = 0) uniform uint firstTile;   // of this dispatch, in `tiles`
layout(location = 1) uniform uvec2 pass;   // cells [x, x + y) are present; pixels that start there are drawn

const float narrowest = 1.0 / 64.0;   // a slab's share that points are spread over at least
const float densest = 2.0;   // optical depth of a segment, about, whose color is taken to change evenly
const float deepestMixed = 0.5;   // the same where something else may be mixed with it
Sample front[LAYERS];     // of the current segment
float sampledTo = -1.0;   // where it was sampled
#if POINTS
vec3 colors[LAYERS];      // of points in this pixel
#endif
float reach = 1e30;       // slabs: how long a segment may be by what the last one held
// The points of each layer in the current slab: several are spread evenly between two depths, with so much optical
// depth a slab; a single one (from = to) has its optical depth at one place.
float pointsFrom[LAYERS], pointsTo[LAYERS], pointsDensity[LAYERS], pointTau[LAYERS];
// The slabs of the current word that are still ahead.
uint volumeBits[LAYERS], pointBits[LAYERS], nextCell[LAYERS];

#if DOTS
#include "dots.glsl"
#endif

#if GRIDS
#include "grid.glsl"

// How far it may go from `at`, in its brick, in one segment. `inside`: whether the layer is looked at.
float gridSegment(uint l, float at, bool inside) {
    uint h = l - plots;
    bool seen = brickSeen[h], fine = brickFine[h];
    float leaving = enterBrick(l, at);
    brickSeen[h] = brickSeen[h] && inside;
    // The field jumps where corrections begin or end; where nothing is seen, no sample is right.
    if (brickSeen[h] && !(seen && fine == brickFine[h])) sampledTo = -1.0;
    return brickSeen[h] ? min(leaving, brickStep[h]) : leaving;
}

// `share`: what of it there is.
void shine(inout Piece piece, vec2 shade, float share) {
    piece.matter.rgb = piece.matter.rgb * shade.x + piece.matter.w * shade.y;
    piece.matter *= share;
    piece.change *= shade.x * share;
}
#endif

#if VOLUME && LAYERS > GRIDS
#include "densities.glsl"
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
    float mean = moment / max(weight, 1.0);
    float tau = count * frame.layers[l].point.w;
    if (frame.layers[l].scale.w > 0.0) {
        float depth = depthOf(slab + mean);
        tau /= depth * depth;
    }
    float middle = clamp(mean, narrowest, 1.0);
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
#if GRIDS
        if (l >= plots) {
            float most = gridSegment(l, at, inside);
            next = min(next, inside ? at + most : end);
            continue;
        }
#endif
#if LAYERS > GRIDS
        float most = segment[l];
#if EXACT
        float thin = (layerCount == 1u ? densest : deepestMixed) / max(front[l].extinction * unitLength[l], 1e-20);
        most = min(most, min(nextKink(l, at), thin));
#endif
        next = min(next, inside ? at + most : end);
#endif
#endif
    }
#if DOTS
    next = min(next, dotDepth);
#endif
    next = min(next, at + reach);
    // However close the cuts, each step must go on in single precision.
    return min(max(next, at + 1e-4), end);
}

// Where the ray is inside the layer's box, and how far it may go there in one segment.
void aim(uint l, vec2 at) {
    aimBox(l, at);
#if GRIDS
    if (l >= plots) {
        clipWay(l);
        brickSeen[l - plots] = false;
        unitLength[l] = gridLength(l);
        return;
    }
#endif
#if VOLUME && LAYERS > GRIDS
    clipWay(l);
    unitLength[l] = length(advance[l] * frame.layers[l].edges.xyz);
    float cells = length(advance[l] * frame.layers[l].cells.xyz);
    segment[l] = 1.0 / clamp(cells * frame.window.z * (EXACT == 1 ? 0.25 : 0.5), 1e-3, 64.0);
#endif
}

#if VOLUME
void add(inout Piece all, Piece piece, float length) {
    all.matter += piece.matter * length;
    all.change += piece.change * length;
}

// What all layers hold between two depths, optical depths in place of extinction; `back`: samples at the
// farther one.
Part volumesBetween(float at, float next, bool volume[LAYERS], out Sample back[LAYERS]) {
    float halfSegment = 0.5 * (next - at);
    Part all;
    all.near = all.far = Piece(vec4(0.0), vec3(0.0), 0.0, 0.0);
    all.wanted = 0.0;
    for (uint l = 0u; l < layerCount; ++l) {
        Part part;
        bool seen;
        if (l >= plots) {
#if GRIDS
            Sample middle = gridAt(l, at + halfSegment);
            back[l] = gridAt(l, next);
            part = gridPart(l, front[l], middle, back[l], halfSegment);
            float centre = mix(at, next, centreOf(part));
            vec2 shade = gridShade(l, centre);
            float share = gridShare(l, centre);
            shine(part.near, shade, share);
            shine(part.far, shade, share);
            seen = brickSeen[l - plots];
#endif
        } else {
#if LAYERS > GRIDS
            Sample middle = particlesAt(l, at + halfSegment);
            back[l] = particlesAt(l, next);
            part = particlesPart(l, middle, back[l], halfSegment);
            seen = volume[l] && enters[l] <= at && leaves[l] > at;
#endif
        }
        add(all.near, part.near, seen ? unitLength[l] * halfSegment : 0.0);
        add(all.far, part.far, seen ? unitLength[l] * halfSegment : 0.0);
        all.wanted = max(all.wanted, seen ? part.wanted : 0.0);
    }
    // What is mixed is seen through each other.
    all.depth = max(all.near.matter.w, all.far.matter.w);
    if (layerCount > 1u && next - at > shortest) all.wanted = max(all.wanted, all.depth * (1.0 / deepestMixed));
    return all;
}
#endif

// Gathers from one depth to the next cut; returns it. A segment that says too little of what is in it is
// tried again, shorter.
float gatherSegment(float at, float end, bool volume[LAYERS]) {
    float next = nextCut(at, end, volume);
    vec4 spread = vec4(0.0);
    vec4 single = vec4(0.0);
#if VOLUME
    // After a gap the front must be sampled first: by a segment of no length.
    next = sampledTo == at ? next : at;
    Sample back[LAYERS];
    Part part = volumesBetween(at, next, volume, back);
    reach = nextSegment(next - at, reach, part.wanted);
    if (part.wanted > 1.0) return at;
    front = back;
    sampledTo = next;
#endif
#if POINTS
    for (uint l = 0u; l < layerCount; ++l) {
        vec4 color = vec4(colors[l], 1.0);
        spread += (pointsFrom[l] <= at && pointsTo[l] > at ? pointsDensity[l] : 0.0) * color;
        // A single point ends the segment before it.
        single += (pointsFrom[l] > at && pointsFrom[l] <= next ? pointTau[l] : 0.0) * color;
    }
#endif
    spread *= next - at;
#if VOLUME
    gather(part.near.matter + 0.5 * spread, part.near.change);
    gather(part.far.matter + 0.5 * spread, part.far.change);
#else
    gather(spread);
#endif
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
        depth = gatherSegment(depth, end, volume);
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
#if POINTS
    for (uint l = 0u; l < layerCount; ++l) colors[l] = pointColor(l, place.y * size.x + place.x);
#endif
    walk(tile, pixel, vec2(ndc.x, -ndc.y) * frame.window.xy);
#if DOTS
    passDots(2.0 * float(frame.band.y));
#endif
    store(place.y * size.x + place.x, light, transmittance);
}
