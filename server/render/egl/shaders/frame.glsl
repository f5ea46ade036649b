// SPDX-License-Identifier: GPL-3.0-or-later
// What all shaders know of the frame; mirrors egl/frame_block.h.
//
// A picture is drawn in bands of tile rows. A tile is 8 x 8 pixels; pixels are numbered tile by tile, so that those of
// a workgroup lie side by side. Depth is counted in slabs, from the frame's near depth; it is cut into sections whose
// slabs are of different thickness.

struct Layer {
    mat4 boxToScreen;    // box [0,1]^3 to (px * w, py * w, slab, w), before bends.glsl
    vec4 entry[3];       // SECTIONS 1: box position where a ray meets slab 0: entry[0] + x * entry[1] + y * entry[2]
    vec4 advance[3];     // and how far it moves in the box in one slab, likewise
    vec4 point;          // linear RGB; optical depth of a whole point
    vec4 scale;          // points a unit of weight; how many clips; which of the lists of pixels' colours (colors.glsl) is that
                         // of its points, from 1 on, 0 where they have one colour; 1: the optical depth of a point is
                         // that at depth 1 and goes with its inverse square
    vec4 cells;          // the volume's cells along each axis; what its extinction is times
    vec4 edges;          // of the volume's box, in layer space
    vec4 clips[12];      // in the box: dot(xyz, place) >= w is drawn of the volume
};

layout(std140, binding = 0) uniform Frame {
    ivec4 picture;       // width, height, tiles a row, first tile row of the band
    ivec4 band;          // tiles, slabs, half floats wanted, rows of pixels
    vec4 window;         // half width and half height of the picture at depth 1; samples a cell; what a segment owes
    vec4 background;     // linear RGB
    uvec4 blank;         // a pixel of background, encoded: one or two words
    uvec4 counts;        // layers; words of 32 slab bits a pixel or tile; unused
    vec4 depths;         // SECTIONS 1: the depth at which slab 0 begins; a slab's thickness
    Layer layers[8];
} frame;

uint wordCount = frame.counts.y;

// The number of a pixel of the picture, row 0 on top. FLAT: row by row, which is quicker to compute.
uint pixelNumber(uint x, uint y) {
#ifdef FLAT
#if FLAT
    return (y - uint(frame.picture.w) * 8u) * uint(frame.picture.x) + x;
#endif
#endif
    uint tile = ((y >> 3) - uint(frame.picture.w)) * uint(frame.picture.z) + (x >> 3);
    return tile * 64u + ((y & 7u) << 3) + (x & 7u);
}
