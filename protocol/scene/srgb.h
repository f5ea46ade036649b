// SPDX-License-Identifier: GPL-3.0-or-later
//
// The sRGB transfer function (IEC 61966-2-1): colours are linear inside, encoded at the edges. Pure
// functions.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace mote {

inline double srgbToLinear(double encoded) {
    return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

/// srgbToLinear() of a byte's 255 parts, looked up.
inline double srgbByteToLinear(std::uint8_t encoded) {
    static const auto values = [] {
        std::array<double, 256> all{};
        for (std::size_t i = 0; i < all.size(); ++i) all[i] = srgbToLinear(static_cast<double>(i) / 255.0);
        return all;
    }();
    return values[encoded];
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

/// How bright a linear colour is (Rec. 709).
inline double luminance(const glm::dvec3& color) {
    return glm::dot(color, glm::dvec3(0.2126, 0.7152, 0.0722));
}

/// Whether dark ink shows on it. Middle grey on the screen, 0.5 encoded, is 0.21 of the light.
inline bool isLight(const glm::dvec3& color) {
    return luminance(color) > 0.21;
}

}  // namespace mote
