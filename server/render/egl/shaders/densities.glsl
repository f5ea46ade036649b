// SPDX-License-Identifier: GPL-3.0-or-later
// Volumes of particles along a ray, for composite.comp: what is found at a depth and between depths.

layout(binding = 0) uniform sampler3D volumes[LAYERS - GRIDS];   // cube root of extinction; scaled log density

const float fade = 0.125;   // LogDensity::fade
const float mostOff = 0.002;   // by which the optical depth of a segment may differ from what its ends say
const float colorful = 0.1 * tableCells;   // a change of t over which a colour map does not change evenly
float segment[LAYERS];   // slabs: the most that is gone at once where the volume is

vec2 volumeAt(uint l, float slab) {
    vec3 place = entry[l] + slab * advance[l];
#if GRIDS == 0
    return textureLod(volumes[l], place, 0.0).rg;
#else
    // Textures go by constant numbers, see texelAt() of grid.glsl.
    vec2 found = vec2(0.0);
#define VOLUME_OF(i) if (l == uint(i)) found = textureLod(volumes[i], place, 0.0).rg;
    VOLUME_OF(0)
#if LAYERS - GRIDS > 1
    VOLUME_OF(1)
#endif
#if LAYERS - GRIDS > 2
    VOLUME_OF(2)
#endif
#if LAYERS - GRIDS > 3
    VOLUME_OF(3)
#endif
#if LAYERS - GRIDS > 4
    VOLUME_OF(4)
#endif
#if LAYERS - GRIDS > 5
    VOLUME_OF(5)
#endif
#if LAYERS - GRIDS > 6
    VOLUME_OF(6)
#endif
    return found;
#endif
}

// Extinction changes evenly between two samples that lie between planes of cell centres: nothing hides there, and no
// integral is needed; in its place stands where the colour is in the table.
Sample particlesAt(uint l, float slab) {
    vec2 found = volumeAt(l, slab);
    float cell = clamp(floor((found.y + fade) * (tableCells / (1.0 + fade)) + 1.0), 1.0, tableCells);
    uint color = texelFetch(tables, int(l) * int(tableEntries) + int(cell)).z;
    vec3 root = vec3(color & 1023u, (color >> 10) & 1023u, color >> 20) * (1.0 / 1023.0);
    float cubeRoot = max(found.x, 0.0);
    return Sample(0.0, cell, cubeRoot * cubeRoot * cubeRoot * frame.layers[l].cells.w, 1e30, root * root);
}

void enlarge(inout Piece piece, float times) {
    piece.matter *= times;
    piece.change *= times;
}

// As partOf. In an exact picture the segment lies between two planes of cell centres, so that extinction is smooth in
// it: the depths of its halves and of the whole, each with it taken as linear, are extrapolated (Romberg).
Part particlesPart(uint l, Sample middle, Sample back, float halfSegment) {
    float length = halfSegment * unitLength[l];
    Part part = partOf(front[l], middle, back, length);
#if EXACT
    float off = part.depth - 2.0 * length * pieceOf(front[l], back).matter.w;
    part.wanted = max(part.wanted, part.seen * abs(off) * (2.0 / mostOff));
    float change = max(abs(middle.integral - front[l].integral), abs(back.integral - middle.integral));
    part.wanted = max(part.wanted, min(part.seen * part.depth * (1.0 / shown), 1.0) * change * (1.0 / colorful));
    float scale = max(1.0 + off / max(3.0 * part.depth, 1e-30), 0.0);
    enlarge(part.near, scale);
    enlarge(part.far, scale);
#endif
    limitCuts(part, 2.0 * halfSegment, segment[l] * (1.0 / 16.0));
    return part;
}

// How far from `slab` the ray next crosses a plane of cell centres, where extinction has a kink.
float nextKink(uint l, float slab) {
    vec3 speed = advance[l] * frame.layers[l].cells.xyz;
    vec3 place = (entry[l] + slab * advance[l]) * frame.layers[l].cells.xyz - 0.5;
    vec3 way = sign(speed);
    // A crossing less than a thousandth of a cell ahead counts as passed, or rounding would find it again.
    vec3 plane = floor(place * way + 1.001) * way;
    vec3 distance = (plane - place) / mix(speed, vec3(1e-30), lessThan(abs(speed), vec3(1e-20)));
    distance = mix(distance, vec3(1e30), lessThan(abs(speed), vec3(1e-20)));
    return min(distance.x, min(distance.y, distance.z));
}
