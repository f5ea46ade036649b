// SPDX-License-Identifier: GPL-3.0-or-later
//
// The sRGB transfer function (IEC 61966-2-1): colours are linear inside, encoded at the edges. Pure
// functions.
#pragma once

#include <cmath>
#include <glm/vec3.hpp>

namespace mote {

inline double srgbToLinear(double encoded) {
    return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

inline double linearToSrgb(double linear) {
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

inline glm::dvec3 srgbToLinear(const glm::dvec3& encoded) {
    return {srgbToLinear(encoded.x), srgbToLinear(encoded.y), srgbToLinear(encoded.z)};
}

inline glm::dvec3 linearToSrgb(const glm::dvec3& linear) {
    return {linearToSrgb(linear.x), linearToSrgb(linear.y), linearToSrgb(linear.z)};
}

}  // namespace mote
