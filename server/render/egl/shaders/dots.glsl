// SPDX-License-Identifier: GPL-3.0-or-later
// The dots of a tile along a pixel's ray, front to back, for composite.comp.

layout(binding = 12) uniform samplerBuffer dotData;                        // x, y, reach, slab; color, opacity
layout(binding = 13) uniform usamplerBuffer dotLists;                      // where each list begins; dots

const float beyond = 1e30;   // slabs: where a pixel without further dots has the next
int dotAt, dotEnd;           // in dotLists
float dotDepth = beyond;     // of the pixel's next dot
vec4 dotInk;                 // its color; its opacity in this pixel
vec2 pixelCentre;

// Goes on to the next dot that covers the pixel, from dotAt on.
void findDot() {
    dotDepth = beyond;
    while (dotAt < dotEnd && dotDepth == beyond) {
        int index = 2 * int(texelFetch(dotLists, dotAt).x);
        vec4 place = texelFetch(dotData, index);
        dotInk = texelFetch(dotData, index + 1);
        dotInk.a *= clamp(place.z - distance(pixelCentre, place.xy), 0.0, 1.0);
        dotDepth = dotInk.a > 0.0 ? place.w : beyond;
        ++dotAt;
    }
}

// The dots up to a depth.
void passDots(float to) {
    while (dotDepth <= to) {
        light += transmittance * dotInk.a * dotInk.rgb;
        transmittance *= 1.0 - dotInk.a;
        findDot();
    }
}

void aimDots(uint tile, vec2 centre) {
    pixelCentre = centre;
    dotAt = int(texelFetch(dotLists, int(tile)).x);
    dotEnd = int(texelFetch(dotLists, int(tile) + 1).x);
    findDot();
}
