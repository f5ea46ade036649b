// SPDX-License-Identifier: GPL-3.0-or-later
// A pixel's ray through the layers' boxes, and what it has gathered; for composite.comp and composite_grid.comp.

const float opaque = 5e-5;      // a transmittance that no 8-bit picture shows
const uint layerCount = uint(LAYERS);
const uint plots = layerCount - uint(GRIDS);   // points and densities; those after them are fields of samples

vec3 light = vec3(0.0);
float transmittance = 1.0;

// Rays told in slabs; unitLength: a slab's, in layer space.
vec3 entry[LAYERS], advance[LAYERS];
float enters[LAYERS], leaves[LAYERS], unitLength[LAYERS];

// `matter`: optical depth times color; optical depth. `change`: by how much its color, times optical depth, changes evenly
// from front to back. What is dense shows its front.
void gather(vec4 matter, vec3 change) {
    float passed = exp(-matter.w);
    float share = matter.w < 1e-3 ? 1.0 - 0.5 * matter.w : (1.0 - passed) / matter.w;
    float before = matter.w < 1e-2 ? matter.w * (1.0 / 12.0) : 0.5 * share - (share - passed) / matter.w;
    light += transmittance * (share * matter.rgb - before * change);
    transmittance *= passed;
}

void gather(vec4 matter) {
    gather(matter, vec3(0.0));
}

// The section of the depth that the ray goes through: slabs [first, end).
float sectionFirst = 0.0, sectionEnd;
#if SECTIONS > 1
// Each section's end and first slab, then each layer's entry[3] and advance[3], as Layer has them.
layout(std430, binding = 3) readonly buffer Sections { vec4 sections[]; };
const uint sectionSize = 1u + 6u * layerCount;
uint sectionAt = 0u;

void enterSection(uint number) {
    sectionAt = number * sectionSize;
    sectionEnd = sections[sectionAt].x;
    sectionFirst = sections[sectionAt].y;
}
#endif

// World units along the line of sight, of a place in slabs within the section.
float depthOf(float slab) {
#if SECTIONS > 1
    return sections[sectionAt].z + (slab - sections[sectionAt].y) * sections[sectionAt].w;
#else
    return frame.depths.x + slab * frame.depths.y;
#endif
}

vec3 rayRow(uint l, uint row, vec2 at) {
#if SECTIONS > 1
    uint first = sectionAt + 1u + 6u * l + 3u * row;
    return sections[first].xyz + at.x * sections[first + 1u].xyz + at.y * sections[first + 2u].xyz;
#else
    return row == 0u ? frame.layers[l].entry[0].xyz + at.x * frame.layers[l].entry[1].xyz +
                           at.y * frame.layers[l].entry[2].xyz
                     : frame.layers[l].advance[0].xyz + at.x * frame.layers[l].advance[1].xyz +
                           at.y * frame.layers[l].advance[2].xyz;
#endif
}

// Where the ray is inside the layer's box, in the section.
void aimBox(uint l, vec2 at) {
    entry[l] = rayRow(l, 0u, at);
    advance[l] = rayRow(l, 1u, at);
    vec3 safe = mix(advance[l], vec3(1e-30), lessThan(abs(advance[l]), vec3(1e-30)));
    vec3 a = -entry[l] / safe;
    vec3 b = (vec3(1.0) - entry[l]) / safe;
    vec3 low = min(a, b);
    vec3 high = max(a, b);
    enters[l] = max(max(low.x, low.y), max(low.z, sectionFirst));
    leaves[l] = min(min(high.x, high.y), min(high.z, sectionEnd));
}

// Cuts the ray's way through the layer where the clips do.
void clipWay(uint l) {
    for (int i = 0; i < int(frame.layers[l].scale.y); ++i) {
        vec4 side = frame.layers[l].clips[i];
        float height = dot(side.xyz, entry[l]) - side.w;
        float rise = dot(side.xyz, advance[l]);
        float at = -height / (rise == 0.0 ? 1.0 : rise);
        enters[l] = rise > 0.0 ? max(enters[l], at) : enters[l];
        leaves[l] = rise < 0.0 ? min(leaves[l], at) : rise == 0.0 && height < 0.0 ? -1.0 : leaves[l];
    }
}
