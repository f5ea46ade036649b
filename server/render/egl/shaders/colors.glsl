// SPDX-License-Identifier: GPL-3.0-or-later
// The colours of points: one, or where they are coloured by a column those of the pixels. Needs frame.glsl; compiled with
// COLORS (0: all have one).
#if COLORS
layout(binding = 15) uniform samplerBuffer pixelColors;   // [list][pixel of the band], row by row
#endif

vec3 pointColor(uint l, uint pixel) {
#if COLORS
    uint list = uint(frame.layers[l].scale.z);
    uint pixels = uint(frame.picture.x * frame.band.w);
    if (list > 0u) return texelFetch(pixelColors, int((list - 1u) * pixels + pixel)).rgb;
#endif
    return frame.layers[l].point.rgb;
}
