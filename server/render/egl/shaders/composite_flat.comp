// SPDX-License-Identifier: GPL-3.0-or-later
// One invocation a pixel: the points of one layer, without anything that could lie between them.
#include "frame.glsl"
#include "pixel.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(std430, binding = 2) readonly buffer Cells { uint cells[]; };   // weights: [pixel]

layout(location = 0) uniform uint firstTile;

void main() {
    uint tile = firstTile + gl_WorkGroupID.x;
    uvec2 place = uvec2(tile % uint(frame.picture.z), tile / uint(frame.picture.z)) * 8u + gl_LocalInvocationID.xy;
    uint weight = cells[tile * 64u + gl_LocalInvocationIndex];
    bool inside = place.x < uint(frame.picture.x) && place.y + uint(frame.picture.w) * 8u < uint(frame.picture.y);
    if (weight == 0u || !inside) return;
    float transmittance = exp(-float(weight) * frame.layers[0].scale.x * frame.layers[0].point.w);
    store(place.y * uint(frame.picture.x) + place.x, (1.0 - transmittance) * frame.layers[0].point.rgb, transmittance);
}
