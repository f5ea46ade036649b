// SPDX-License-Identifier: GPL-3.0-or-later
// What transfer functions make of a field, of densities or of samples: of a place on a ray, and of what lies between
// places. Needs ray.glsl.

// [layer][x], TransferTable: the integral of extinction up to x and extinction there, as floats; color; in the upper half
// of a word that of a float, half of how extinction changes up to x + 1, in the lower half how far it is from x to
// where something is seen.
layout(binding = 8) uniform usamplerBuffer tables;

const float tableCells = 4095.0;
const float tableEntries = tableCells + 2.0;   // of a layer
// A part is cut where x changes by more in one of its halves, and from so much optical depth on.
const float steepest = 0.05 * tableCells, shown = 0.02;
const float shortest = 1e-3;   // slabs: an eighth of that still goes on in single precision

// A place on a ray: where it is in the table and what is found there.
struct Sample {
    float x, integral, extinction, away;
    vec3 color;
};

// Takes the nearest 256th of a place: what is constant and lies right on a step of a curve stays on its side
// of it.
Sample sampleOf(uint l, float place) {
    float x = floor(place * 256.0 + 0.5) * (1.0 / 256.0);
    float cell = clamp(floor(x), 0.0, tableEntries - 1.0);   // beyond the table's ends it goes on as there
    uvec4 entry = texelFetch(tables, int(l) * int(tableEntries) + int(cell));
    float rest = x - cell;
    float bend = uintBitsToFloat(entry.w & 0xffff0000u) * rest;
    float slope = uintBitsToFloat(entry.y) + bend;
    vec3 root = vec3(entry.z & 1023u, (entry.z >> 10) & 1023u, entry.z >> 20) * (1.0 / 1023.0);
    return Sample(x, uintBitsToFloat(entry.x) + slope * rest, slope + bend, float(entry.w & 0xffffu), root * root);
}

// What lies between two samples, x being taken as linear.
struct Piece {
    vec4 matter;    // mean of (extinction * color, extinction)
    vec3 change;    // of extinction * color, evenly from front to back
    float centre;   // of extinction, as a share of the way
    float bend;     // of extinction
};

Piece pieceOf(Sample front, Sample back) {
    float way = back.x - front.x;
    float level = 0.5 * (front.extinction + back.extinction);
    float rise = back.extinction - front.extinction;
    float mean = max(abs(way) > 1.0 ? (back.integral - front.integral) / way : level, 0.0);
    // Where extinction changes evenly; with the true mean also where it begins or ends on the way.
    float centre = clamp(0.5 + rise / max(12.0 * mean, 1e-30), 0.0, 1.0);
    return Piece(mean * vec4(mix(front.color, back.color, centre), 1.0), mean * (back.color - front.color), centre,
                 4.0 * abs(mean - level) + abs(rise));
}

// What lies from a sample to another through one in their middle.
struct Part {
    Piece near, far;
    float depth;    // optical
    float seen;     // what of light from there is seen, at least a little
    float wanted;   // into how many it should be cut; at most 1: it does as it is
};

// `length`: of each half, in layer space. Where x changes much it is cut, as far as that shows. Where nothing shows,
// something may hide: a smooth x leaves the range of three samples by an eighth of how much they bend, one with a kink
// by a half, one with several by about as much as they bend.
Part partOf(Sample front, Sample middle, Sample back, float length) {
    Part part;
    part.near = pieceOf(front, middle);
    part.far = pieceOf(middle, back);
    part.depth = (part.near.matter.w + part.far.matter.w) * length;
    part.seen = max(transmittance, 0.05);
    float worth = min(part.seen * part.depth * (1.0 / shown), 1.0);
    float change = max(abs(middle.x - front.x), abs(back.x - middle.x));
    float bend = abs(front.x + back.x - 2.0 * middle.x);
    bool hides = min(middle.away, min(front.away, back.away)) < bend;
    part.wanted = part.depth > 0.0 ? worth * change * (1.0 / steepest) : hides ? 2.0 : 0.0;
    return part;
}

// Holds what is wanted of a part to what a segment owes, less in motion, and to those longer than `least`; in slabs.
void limitCuts(inout Part part, float segment, float least) {
    part.wanted = segment > max(least, shortest) ? part.wanted * frame.window.w : 0.0;
}

// How long the next segment may be, after one of which so many were `wanted`; `most`: how long that might have been.
float nextSegment(float segment, float most, float wanted) {
    float suited = segment * clamp(0.9 / max(wanted, 1e-3), 0.125, 2.0);
    // One that ended where something else begins says little.
    return wanted <= 1.0 && segment < most ? max(suited, most) : suited;
}
