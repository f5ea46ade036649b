// SPDX-License-Identifier: GPL-3.0-or-later
// Fields of samples along a ray, for composite.comp and composite_grid.comp: which brick of the grid a depth lies in, and
// what is seen between two depths of one brick. Layers from `plots` on are such fields. Mirrors GridBlock of
// egl/frame_block.h. Compiled with MIXED: whether the coarse grid shows in corrected bricks of some layer; SLOPES: whether
// the extinction of some goes by how steeply they change.

struct Grid {
    vec4 grid;          // samples of the grid that is cut into bricks; segments a cell
    vec4 low;           // samples of the coarse grid; segments a cell
    vec4 table;         // code * x + y is a place in the transfer table; z of what corrects shows; steepness
    ivec4 place;        // where its bricks begin in gridBricks; the first texel of slopes
    vec4 toLayer[3];    // the box's edges in layer space; w of the first: how much of its extinction goes by slopes
};
layout(std140, binding = 1) uniform Grids { Grid grids[8]; };
// Five neighbours along x: their codes of 16 bits, then their normals of 8; the fifth is the next one's first. First the
// coarse grid, row after row, then brick after brick; then, if they are asked for, the samples' slopes, a byte each.
layout(binding = LAYERS - GRIDS) uniform usamplerBuffer gridSamples[GRIDS];
// One word a brick: its number among the corrected ones plus 1, or 0, in 21 bits; in 3 how much longer than
// usual a segment may be, as a power of two; in 6 how many bricks it is to one of another kind; 2 where
// something is seen in it. At the beginning the shades of each layer's normals, two of 16 bits.
layout(binding = 14) uniform usamplerBuffer gridBricks;

const int brickRow = 2, brickSheet = 9 * brickRow, brickTexels = 9 * brickSheet;
// A segment is cut where it absorbs more or extinction bends by more in one of its halves: optical depths.
const float deepest = 0.1, mostBent = 0.012;
const float lightEvery = 0.005;   // optical depth for which light is looked up once

// Samples: where they begin, how far it is to the next row and sheet; a place of the box is place * scale - shift in
// them, held within 0 and `most`. Half way between two of them their weights change `steepness` times faster than evenly.
struct Samples {
    int base;
    ivec2 stride;
    vec3 scale, shift, most;
    float steepness;
    int first;    // samples in place of texels, likewise
    ivec2 step;
};

// The brick of the current segment.
bool brickSeen[GRIDS];
bool brickFine[GRIDS];
float brickStep[GRIDS];   // slabs, of a segment
Samples brickSamples[GRIDS];

Samples lowSamples(uint h) {
    ivec3 low = ivec3(grids[h].low.xyz);
    int row = max((low.x + 2) / 4, 1);
    return Samples(0, ivec2(row, row * low.y), vec3(low), vec3(0.5), vec3(low - 1), 1.0, 0, ivec2(low.x, low.x * low.y));
}

vec3 placeAt(uint l, float slab) {
    return entry[l] + slab * advance[l];
}

// How far it is from `at` to the border of its brick or, where nothing is seen, of all around in which nothing is.
float enterBrick(uint l, float at) {
    uint h = l - plots;
    vec3 size = grids[h].grid.xyz;
    vec3 way = sign(advance[l]);
    vec3 speed = advance[l] * size;
    vec3 place = placeAt(l, at) * size - 0.5;
    ivec3 count = (ivec3(size) + 7) / 8;
    // A border less than a thousandth of a cell ahead counts as passed, or rounding would find it again.
    ivec3 brick = clamp(ivec3(floor((place + 1e-3 * way) * 0.125)), ivec3(0), count - 1);
    uint word = texelFetch(gridBricks, grids[h].place.x + (brick.z * count.y + brick.y) * count.x + brick.x).x;
    int number = int(word & 0x1fffffu) - 1;
    brickSeen[h] = (word >> 30) != 0u;
    int around = brickSeen[h] ? 1 : int(word >> 24) & 63;
    bvec3 ahead = greaterThan(way, vec3(0.0));
    ivec3 past = brick + mix(ivec3(1 - around), ivec3(around), ahead);
    // The outermost bricks reach to the box's faces and beyond.
    bvec3 open = bvec3(ivec3(lessThan(abs(speed), vec3(1e-20))) |
                       (ivec3(not(ahead)) & ivec3(lessThanEqual(past, ivec3(0)))));
    vec3 distance = mix((8.0 * vec3(past) - place) / mix(speed, vec3(1.0), open), vec3(1e30), open);
    bool fine = number >= 0;
    Samples low = lowSamples(h);
    brickSamples[h].base = fine ? low.stride.y * int(grids[h].low.z) + number * brickTexels : 0;
    brickSamples[h].stride = fine ? ivec2(brickRow, brickSheet) : low.stride;
    brickSamples[h].scale = fine ? size : low.scale;
    brickSamples[h].shift = fine ? 0.5 + 8.0 * vec3(brick) : low.shift;
    brickSamples[h].most = fine ? min(size - 1.0 - 8.0 * vec3(brick), vec3(8.0)) : low.most;
    brickSamples[h].steepness = fine ? grids[h].table.w : 1.0;
    brickSamples[h].first = fine ? low.step.y * int(grids[h].low.z) + number * 729 : 0;
    brickSamples[h].step = fine ? ivec2(9, 81) : low.step;
    brickFine[h] = fine;
    float segments = fine ? grids[h].grid.w : grids[h].low.w;
    float longer = float(1u << ((word >> 21) & 7u));
    brickStep[h] = longer / max(length(advance[l] * brickSamples[h].scale) * segments, 1e-20);
    return min(distance.x, min(distance.y, distance.z));
}

// Where the eight samples around are: the texel of the first, which of its samples, and how far it is to the next row and
// sheet; what the others weigh.
struct Corner {
    int texel, inTexel;
    ivec2 stride;
    vec3 far;
};

Corner cornerAt(Samples samples, vec3 inBox) {
    vec3 place = clamp(inBox * samples.scale - samples.shift, vec3(0.0), samples.most);
    ivec3 cell = ivec3(min(place, max(samples.most - 1.0, vec3(0.0))));
    int texel = samples.base + (cell.x >> 2) + cell.y * samples.stride.x + cell.z * samples.stride.y;
    vec3 far = clamp((place - vec3(cell) - 0.5) * samples.steepness + 0.5, vec3(0.0), vec3(1.0));
    return Corner(texel, cell.x & 3, samples.stride, far);
}

// Samplers go by constant numbers: where some of its pixels are done with a loop, llvmpipe takes a sampler's
// number from one of them.
uvec4 texelAt(uint h, int index) {
    uvec4 texel = uvec4(0u);
#define FROM(i) if (h == uint(i)) texel = texelFetch(gridSamples[i], index);
    FROM(0)
#if GRIDS > 1
    FROM(1)
#endif
#if GRIDS > 2
    FROM(2)
#endif
#if GRIDS > 3
    FROM(3)
#endif
#if GRIDS > 4
    FROM(4)
#endif
#if GRIDS > 5
    FROM(5)
#endif
#if GRIDS > 6
    FROM(6)
#endif
#if GRIDS > 7
    FROM(7)
#endif
    return texel;
}

// The code between a sample and the next one along x.
float codeAt(uint h, int index, Corner corner) {
    uvec4 texel = texelAt(h, index);
    bool later = corner.inTexel >= 2;
    uint first = later ? texel.y : texel.x, next = later ? texel.z : texel.y;
    uint pair = (corner.inTexel & 1) == 0 ? first : first >> 16 | next << 16;
    return mix(float(pair & 0xffffu), float(pair >> 16), corner.far.x);
}

// What `along` gives between samples along x, at a corner's place.
#define BETWEEN(along, h, at) \
    mix(mix(along(h, at.texel, at), along(h, at.texel + at.stride.x, at), at.far.y), \
        mix(along(h, at.texel + at.stride.y, at), along(h, at.texel + at.stride.y + at.stride.x, at), at.far.y), at.far.z)

float valueIn(uint h, Corner corner) {
    return BETWEEN(codeAt, h, corner);
}

#if MIXED
// What of the samples of the brick shows, and not the coarse grid.
float shareOfBrick(uint h) {
    return brickFine[h] ? grids[h].table.z : 1.0;
}
#endif

Sample gridAt(uint l, float slab) {
    uint h = l - plots;
    vec3 place = placeAt(l, slab);
    float code = valueIn(h, cornerAt(brickSamples[h], place));
#if MIXED
    code = mix(valueIn(h, cornerAt(lowSamples(h), place)), code, shareOfBrick(h));
#endif
    return sampleOf(l, code * grids[h].table.x + grids[h].table.y);
}

// Likewise.
vec2 shadeOf(uint h, int index, Corner corner) {
    uvec4 texel = texelAt(h, index);
    uint normals = (corner.inTexel >= 2 ? texel.w : texel.z >> 16 | texel.w << 16) >> (8 * (corner.inTexel & 1));
    vec2 near = unpackUnorm2x16(texelFetch(gridBricks, int(h * 256u + (normals & 255u))).x);
    vec2 next = unpackUnorm2x16(texelFetch(gridBricks, int(h * 256u + ((normals >> 8) & 255u))).x);
    return mix(near, next, corner.far.x);
}

vec2 shadeIn(uint h, Corner corner) {
    return BETWEEN(shadeOf, h, corner);
}

vec2 gridShade(uint l, float slab) {
    uint h = l - plots;
    vec3 place = placeAt(l, slab);
    vec2 shade = shadeIn(h, cornerAt(brickSamples[h], place));
#if MIXED
    shade = mix(shadeIn(h, cornerAt(lowSamples(h), place)), shade, shareOfBrick(h));
#endif
    return shade;
}

#if SLOPES
float slopeAt(uint h, int index) {
    uvec4 texel = texelAt(h, grids[h].place.y + (index >> 4));
    int word = (index >> 2) & 3;
    uint bytes = word < 2 ? (word == 0 ? texel.x : texel.y) : (word == 2 ? texel.z : texel.w);
    return float((bytes >> (8 * (index & 3))) & 255u);
}

float slopeOf(uint h, int index, Corner corner) {
    return mix(slopeAt(h, index), slopeAt(h, index + 1), corner.far.x);
}

// Between the samples around, 0 to 255: the corner told in samples, in place of texels.
float slopeIn(uint h, Samples samples, vec3 inBox) {
    vec3 place = clamp(inBox * samples.scale - samples.shift, vec3(0.0), samples.most);
    ivec3 cell = ivec3(min(place, max(samples.most - 1.0, vec3(0.0))));
    Corner corner = cornerAt(samples, inBox);
    corner.texel = samples.first + cell.x + cell.y * samples.step.x + cell.z * samples.step.y;
    corner.stride = samples.step;
    return BETWEEN(slopeOf, h, corner);
}
#endif

// What of the extinction there is.
float gridShare(uint l, float slab) {
#if SLOPES
    uint h = l - plots;
    float gradient = grids[h].toLayer[0].w;
    if (gradient == 0.0) return 1.0;
    vec3 place = placeAt(l, slab);
    float slope = slopeIn(h, brickSamples[h], place);
#if MIXED
    slope = mix(slopeIn(h, lowSamples(h), place), slope, shareOfBrick(h));
#endif
    return 1.0 - gradient + gradient * slope * (1.0 / 255.0);
#else
    return 1.0;
#endif
}

// As partOf, of samples half a segment apart.
Part gridPart(uint l, Sample front, Sample middle, Sample back, float halfSegment) {
    float length = halfSegment * unitLength[l];
    Part part = partOf(front, middle, back, length);
    float bent = part.depth > 0.0 ? max(part.near.bend, part.far.bend) * length : 0.0;
    part.wanted = max(part.wanted, part.seen * max(part.depth * (1.0 / deepest), bent * (1.0 / mostBent)));
    limitCuts(part, 2.0 * halfSegment, brickStep[l - plots] * (1.0 / 128.0));
    return part;
}

// Where a part's extinction is, from 0 at its front to 1 at its back.
float centreOf(Part part) {
    float near = part.near.matter.w, far = part.far.matter.w;
    return 0.5 * (near * part.near.centre + far * (1.0 + part.far.centre)) / max(near + far, 1e-30);
}

// A way through a layer, and what was gathered since its light was looked up.
struct Way {
    float at, segment;   // slabs
    Sample front;        // at `at`
    float tau, moment;   // optical depth; times its place
    vec3 color;          // times optical depth, without light
};

Way wayFrom(uint l, float slab) {
    return Way(slab, brickStep[l - plots], gridAt(l, slab), 0.0, 0.0, vec3(0.0));
}

// One segment further; where that says too little, a shorter one comes first.
void goOn(uint l, float to, inout Way way) {
    float next = min(way.at + way.segment, to);
    float halfSegment = 0.5 * (next - way.at);
    Sample middle = gridAt(l, way.at + halfSegment), back = gridAt(l, next);
    Part part = gridPart(l, way.front, middle, back, halfSegment);
    way.segment = min(nextSegment(next - way.at, way.segment, part.wanted), brickStep[l - plots]);
    if (part.wanted <= 1.0) {
        vec4 matter = (part.near.matter + part.far.matter) * halfSegment * unitLength[l];
        way.tau += matter.w;
        way.moment += matter.w * mix(way.at, next, centreOf(part));
        way.color += matter.rgb;
        way.at = next;
        way.front = back;
    }
}

// What was gathered, in its light: optical depth times color; optical depth.
vec4 litMatter(uint l, inout Way way) {
    float at = way.tau > 0.0 ? way.moment / way.tau : way.at;
    vec2 shade = gridShade(l, at);
    vec4 matter = gridShare(l, at) * vec4(way.color * shade.x + way.tau * shade.y, way.tau);
    way.tau = way.moment = 0.0;
    way.color = vec3(0.0);
    return matter;
}

// A slab's length in layer space.
float gridLength(uint l) {
    uint h = l - plots;
    return length(grids[h].toLayer[0].xyz * advance[l].x + grids[h].toLayer[1].xyz * advance[l].y +
                  grids[h].toLayer[2].xyz * advance[l].z);
}
