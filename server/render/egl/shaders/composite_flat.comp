// SPDX-License-Identifier: GPL-3.0-or-later
// One invocation a pixel: the points of one layer, without anything that could lie between them. Compiled with COLORS.
#include "frame.glsl"
#include "pixel.glsl"
#include "colors.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = 2) readonly buffer Cells { uint cells[]; };   // weights: pixel by pixel, row by row

layout(location = 0) uniform uint firstTile;   // here a run of 64 pixels

void main() {
    uint number = (firstTile + gl_WorkGroupID.x) * 64u + gl_LocalInvocationID.x;
    uint weight = cells[number];
    if (weight == 0u || number >= uint(frame.picture.x * frame.band.w)) return;
    float transmittance = exp(-float(weight) * frame.layers[0].scale.x * frame.layers[0].point.w);
    store(number, (1.0 - transmittance) * pointColor(0u, number), transmittance);
}
