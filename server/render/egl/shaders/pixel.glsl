// SPDX-License-Identifier: GPL-3.0-or-later
// The way out of the composite shaders: a pixel's colour, encoded and stored.

layout(std430, binding = 7) writeonly buffer Pixels { uint pixels[]; };   // row by row from the band's first

vec3 encoded(vec3 linear) {   // IEC 61966-2-1
    vec3 curved = 1.055 * pow(max(linear, vec3(1e-9)), vec3(1.0 / 2.4)) - 0.055;
    return mix(curved, 12.92 * linear, lessThanEqual(linear, vec3(0.0031308)));
}

/// `light` with what comes through of the background.
void store(uint number, vec3 light, float transmittance) {
    vec3 color = light + transmittance * frame.background.rgb;
    bool blank = transmittance == 1.0;   // the very same value as in tiles that are left blank
    if (frame.band.z != 0) {
        pixels[2u * number] = blank ? frame.blank.x : packHalf2x16(color.rg);
        pixels[2u * number + 1u] = blank ? frame.blank.y : packHalf2x16(vec2(color.b, 1.0));
    } else {
        pixels[number] = blank ? frame.blank.x : packUnorm4x8(vec4(encoded(clamp(color, 0.0, 1.0)), 1.0));
    }
}
