// SPDX-License-Identifier: GPL-3.0-or-later
// Depths of a layer, linear in its box's places, told in slabs of the first section of the depth that it lies in, become
// slabs of the picture (server/render/plan/depth_sections.h). The array is mostSections long.

uniform vec3 bends[17];
uniform vec3 bendShape;   // how many bends; the layer's first slab; how many it has

float bent(float linear) {
    precise float slab = linear;   // points_mark and points_add must find the very same
    for (int i = 0; i < int(bendShape.x); ++i) {
        if (linear > bends[i].x) slab = bends[i].y + (linear - bends[i].x) * bends[i].z;
    }
    return slab;
}
