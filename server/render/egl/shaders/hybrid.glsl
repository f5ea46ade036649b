// SPDX-License-Identifier: GPL-3.0-or-later
// Hybrid volumes along a ray, for composite.comp: which brick of the grid a depth lies in, and what is seen between two
// depths of one brick. Layers from `plots` on are hybrid. Mirrors HybridBlock of egl/frame_block.h.

struct Hybrid {
    vec4 grid;          // samples of the grid that is cut into bricks; stretches a cell
    vec4 low;           // samples of the low volume; stretches a cell
    vec4 table;         // code * x + y is a place in the transfer table, of which z make a unit of value
    ivec4 place;        // of its first brick in hybridBricks; clips; of the first normals in hybridSamples
    vec4 toLayer[3];    // the box's edges in layer space
    vec4 clips[12];     // in the box: dot(xyz, place) >= w is drawn
};
layout(std140, binding = 1) uniform Hybrids { Hybrid hybrids[8]; };
// Of each sample its code and the next one's along x, 16 bits each; from place.z on their normals, four a word: those of
// sample 2 i and the next one, of sample 2 i + 1 and the next one.
layout(binding = LAYERS - HYBRIDS) uniform usamplerBuffer hybridSamples[HYBRIDS];
// Of each brick: its number among the corrected ones plus 1, or 0; the highest bit: something is seen in it. At the
// beginning the shades of each layer's normals, two of 16 bits.
layout(binding = 14) uniform usamplerBuffer hybridBricks;

const int brickSamples = 9;

// The brick of the current stretch: where its samples begin, how far it is to the next row and sheet; a place of the
// box is place * scale - shift in its samples, held within 0 and `most`.
bool brickSeen[HYBRIDS];
float brickStep[HYBRIDS];   // slabs
int brickBase[HYBRIDS];
ivec2 brickStride[HYBRIDS];
vec3 brickScale[HYBRIDS], brickShift[HYBRIDS], brickMost[HYBRIDS];
// What was found at the end of the stretch before: place in the transfer table, the integral there and its slope.
float brickSampledTo[HYBRIDS], backX[HYBRIDS];
vec4 backIntegral[HYBRIDS], backSlope[HYBRIDS];

vec3 placeAt(uint l, float slab) {
    return entry[l] + slab * advance[l];
}

// How far a stretch may go that begins at `at`: to the border of its brick, and within it one step of sampling; where
// there is no other layer to mix with, gatherBrick() takes the steps.
float enterBrick(uint l, float at) {
    uint h = l - plots;
    vec3 size = hybrids[h].grid.xyz;
    vec3 way = sign(advance[l]);
    vec3 speed = advance[l] * size;
    vec3 place = placeAt(l, at) * size - 0.5;
    ivec3 count = (ivec3(size) + 7) / 8;
    // A border less than a thousandth of a cell ahead counts as passed, or rounding would find it again.
    ivec3 brick = clamp(ivec3(floor((place + 1e-3 * way) * 0.125)), ivec3(0), count - 1);
    bvec3 ahead = greaterThan(way, vec3(0.0));
    vec3 border = 8.0 * vec3(brick + ivec3(ahead));
    // The outermost bricks reach to the box's faces and beyond.
    bvec3 open = bvec3(ivec3(lessThan(abs(speed), vec3(1e-20))) |
                       (ivec3(not(ahead)) & ivec3(equal(brick, ivec3(0)))));
    vec3 distance = mix((border - place) / mix(speed, vec3(1.0), open), vec3(1e30), open);
    float leaving = min(distance.x, min(distance.y, distance.z));
    uint word = texelFetch(hybridBricks, hybrids[h].place.x + (brick.z * count.y + brick.y) * count.x + brick.x).x;
    int number = int(word & 0x7fffffffu) - 1;
    bool fine = number >= 0;
    ivec3 low = ivec3(hybrids[h].low.xyz);
    int base = fine ? (low.x * low.y * low.z + 1) / 2 * 2 + number * (brickSamples * brickSamples * brickSamples) : 0;
    brickSampledTo[h] = base == brickBase[h] ? brickSampledTo[h] : -1.0;
    brickSeen[h] = (word >> 31) != 0u;
    brickBase[h] = base;
    brickStride[h] = fine ? ivec2(brickSamples, brickSamples * brickSamples) : ivec2(low.x, low.x * low.y);
    brickScale[h] = fine ? size : vec3(low);
    brickShift[h] = fine ? 0.5 + 8.0 * vec3(brick) : vec3(0.5);
    brickMost[h] = fine ? vec3(8.0) : vec3(low - 1);
    float stretches = fine ? hybrids[h].grid.w : hybrids[h].low.w;
    brickStep[h] = 1.0 / max(length(advance[l] * brickScale[h]) * stretches, 1e-20);
    return brickSeen[h] && layerCount > 1u ? min(leaving, brickStep[h]) : leaving;
}

// The first of the eight samples around, and how far it is to the others.
int samplesAt(uint l, float slab, out vec3 far) {
    uint h = l - plots;
    vec3 place = clamp(placeAt(l, slab) * brickScale[h] - brickShift[h], vec3(0.0), brickMost[h]);
    vec3 cell = min(floor(place), max(brickMost[h] - 1.0, vec3(0.0)));
    far = place - cell;
    return brickBase[h] + int(cell.x) + int(cell.y) * brickStride[h].x + int(cell.z) * brickStride[h].y;
}

// By constant numbers: where some of its pixels are done with a loop, llvmpipe takes a sampler's number from one of them.
uint wordAt(uint h, int index) {
    uint word = 0u;
#define FROM(i) if (h == uint(i)) word = texelFetch(hybridSamples[i], index).x;
    FROM(0)
#if HYBRIDS > 1
    FROM(1)
#endif
#if HYBRIDS > 2
    FROM(2)
#endif
#if HYBRIDS > 3
    FROM(3)
#endif
#if HYBRIDS > 4
    FROM(4)
#endif
#if HYBRIDS > 5
    FROM(5)
#endif
#if HYBRIDS > 6
    FROM(6)
#endif
#if HYBRIDS > 7
    FROM(7)
#endif
    return word;
}

float codeAt(uint h, int index, float far) {
    uint word = wordAt(h, index);
    return mix(float(word & 0xffffu), float(word >> 16), far);
}

// Place in the transfer table.
float hybridAt(uint l, float slab) {
    uint h = l - plots;
    vec3 far;
    int index = samplesAt(l, slab, far);
    int next = index + brickStride[h].y;
    float front = mix(codeAt(h, index, far.x), codeAt(h, index + brickStride[h].x, far.x), far.y);
    float back = mix(codeAt(h, next, far.x), codeAt(h, next + brickStride[h].x, far.x), far.y);
    return mix(front, back, far.z) * hybrids[h].table.x + hybrids[h].table.y;
}

vec2 shadeOf(uint h, int index, float far) {
    uint pair = wordAt(h, hybrids[h].place.z + (index >> 1)) >> (16 * (index & 1));
    vec2 near = unpackUnorm2x16(texelFetch(hybridBricks, int(h * 256u + (pair & 255u))).x);
    return mix(near, unpackUnorm2x16(texelFetch(hybridBricks, int(h * 256u + ((pair >> 8) & 255u))).x), far);
}

vec2 hybridShade(uint l, float slab) {
    uint h = l - plots;
    vec3 far;
    int index = samplesAt(l, slab, far);
    int next = index + brickStride[h].y;
    vec2 front = mix(shadeOf(h, index, far.x), shadeOf(h, index + brickStride[h].x, far.x), far.y);
    vec2 back = mix(shadeOf(h, next, far.x), shadeOf(h, next + brickStride[h].x, far.x), far.y);
    return mix(front, back, far.z);
}

vec4 hybridIntegral(uint l, float x, out vec4 slope) {
    float cell = clamp(floor(x), 0.0, tableCells - 1.0);   // beyond the table's ends it goes on as there
    int index = int(l) * (int(tableCells) + 1) + int(cell);
    vec4 low = texelFetch(transfers, index);
    slope = texelFetch(transfers, index + 1) - low;
    return low + (x - cell) * slope;
}

// What a stretch gathers on its own: its parts one after the other, since the color of what is dense is that of its
// front. Light, and optical depth.
vec4 gatherParts(uint l, float frontX, vec4 integral, vec4 slope, float x, float span, float parts, vec2 shade) {
    vec3 color = vec3(0.0);
    float left = 1.0, tau = 0.0;
    for (float part = 1.0; part <= parts; part += 1.0) {
        vec4 aheadSlope;
        vec4 ahead = hybridIntegral(l, mix(frontX, x, part / parts), aheadSlope);
        vec4 mean = abs(x - frontX) > parts ? (ahead - integral) * (parts / (x - frontX)) : 0.5 * (slope + aheadSlope);
        mean = max(mean, vec4(0.0));
        float depth = mean.w * span / parts;
        float absorbed = depth < 1e-3 ? depth - 0.5 * depth * depth : 1.0 - exp(-depth);
        color += left * absorbed * (mean.rgb * (shade.x / max(mean.w, 1e-30)) + shade.y);
        left *= 1.0 - absorbed;
        tau += depth;
        integral = ahead;
        slope = aheadSlope;
    }
    // So that what the stretch gathers as a whole is what its parts did.
    return vec4(color * (tau < 1e-3 ? 1.0 + 0.5 * tau : tau / (1.0 - left)), tau);
}

// Mean of (extinction * lit color, extinction) per slab over a stretch within one brick; the value taken as linear, the
// light as it is where the middle of its extinction is.
vec4 hybridBetween(uint l, float from, float to) {
    uint h = l - plots;
    for (int turn = brickSampledTo[h] == from ? 0 : 1; turn > 0; --turn) {
        backX[h] = hybridAt(l, from);
        backIntegral[h] = hybridIntegral(l, backX[h], backSlope[h]);
    }
    float frontX = backX[h];
    vec4 integral = backIntegral[h], slope = backSlope[h];
    float x = hybridAt(l, to);
    backX[h] = x;
    backIntegral[h] = hybridIntegral(l, x, backSlope[h]);
    brickSampledTo[h] = to;
    float span = (to - from) * unitLength[l] * hybrids[h].table.z;
    float change = x - frontX;
    float mean = abs(change) > 1.0 ? (backIntegral[h].w - integral.w) / change : 0.5 * (slope.w + backSlope[h].w);
    vec4 matter = vec4(0.0);
    // A loop and not a condition: most stretches in visible bricks show nothing.
    for (int turn = mean * span > 1e-6 ? 1 : 0; turn > 0; --turn) {
        float share = (slope.w + 2.0 * backSlope[h].w) / max(3.0 * (slope.w + backSlope[h].w), 1e-30);
        vec2 shade = hybridShade(l, mix(from, to, clamp(share, 0.0, 1.0)));
        float parts = clamp(ceil(2.0 * mean * span), 1.0, 6.0);
        matter = gatherParts(l, frontX, integral, slope, x, span, parts, shade) / (to - from);
    }
    return matter;
}

// All that a brick of the only layer shows between two depths.
void gatherBrick(float from, float to) {
    while (from < to && transmittance > opaque) {
        float next = min(from + brickStep[0], to);
        gather(hybridBetween(0u, from, next) * (next - from));
        from = next;
    }
}

// Cuts the ray's way through the layer where the clips do.
void clipWay(uint l) {
    uint h = l - plots;
    for (int i = 0; i < hybrids[h].place.y; ++i) {
        vec4 side = hybrids[h].clips[i];
        float height = dot(side.xyz, entry[l]) - side.w;
        float rise = dot(side.xyz, advance[l]);
        float at = -height / (rise == 0.0 ? 1.0 : rise);
        enters[l] = rise > 0.0 ? max(enters[l], at) : enters[l];
        leaves[l] = rise < 0.0 ? min(leaves[l], at) : rise == 0.0 && height < 0.0 ? -1.0 : leaves[l];
    }
}

// Per slab, in layer space.
float hybridLength(uint l) {
    uint h = l - plots;
    return length(hybrids[h].toLayer[0].xyz * advance[l].x + hybrids[h].toLayer[1].xyz * advance[l].y +
                  hybrids[h].toLayer[2].xyz * advance[l].z);
}
