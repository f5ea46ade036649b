// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/hybrid/bubble.h"

#include <algorithm>
#include <cmath>

namespace mote::bench {
namespace {

struct Place {
    float x, y, z;
    Place operator*(float s) const { return {x * s, y * s, z * s}; }
    Place operator+(const Place& p) const { return {x + p.x, y + p.y, z + p.z}; }
};

/// Of a lattice point, -1 to 1.
float lattice(std::int32_t x, std::int32_t y, std::int32_t z) {
    std::uint32_t h = static_cast<std::uint32_t>(x) * 0x8da6b343U ^
                      static_cast<std::uint32_t>(y) * 0xd8163841U ^
                      static_cast<std::uint32_t>(z) * 0xcb1ab31fU;
    h = (h ^ h >> 15U) * 0x2c1b3c6dU;
    h = (h ^ h >> 12U) * 0x297a2d39U;
    h ^= h >> 15U;
    return static_cast<float>(h) * 0x1p-31F - 1.0F;
}

/// Value noise, smooth between lattice points.
float noise(const Place& p) {
    const float fx = std::floor(p.x), fy = std::floor(p.y), fz = std::floor(p.z);
    const auto x = static_cast<std::int32_t>(fx), y = static_cast<std::int32_t>(fy),
               z = static_cast<std::int32_t>(fz);
    const auto smooth = [](float t) { return t * t * (3.0F - 2.0F * t); };
    const float u = smooth(p.x - fx), v = smooth(p.y - fy), w = smooth(p.z - fz);
    const auto mix = [](float a, float b, float t) { return a + t * (b - a); };
    const auto edge = [&](std::int32_t dy, std::int32_t dz) {
        return mix(lattice(x, y + dy, z + dz), lattice(x + 1, y + dy, z + dz), u);
    };
    return mix(mix(edge(0, 0), edge(1, 0), v), mix(edge(0, 1), edge(1, 1), v), w);
}

/// Octaves whose strength falls as in turbulence, by 2^(-5/6) in amplitude from one to the next.
float turbulence(Place p, int octaves) {
    float sum = 0.0F, strength = 1.0F;
    for (int i = 0; i < octaves; ++i) {
        sum += strength * noise(p);
        strength *= 0.5612F;
        p = p * 2.0F + Place{17.3F, -5.1F, 9.7F};
    }
    return sum;
}

}  // namespace

float bubble(float x, float y, float z) {
    const Place p{x, y, z};
    const Place torn =
        p +
        Place{noise(p * 3.0F), noise(p * 3.0F + Place{31, 7, 3}), noise(p * 3.0F + Place{5, 53, 11})} * 0.12F;
    const float radius = std::sqrt(torn.x * torn.x + 1.2F * torn.y * torn.y + torn.z * torn.z);
    if (radius > 1.0F) return 0.0F;
    const float hull = radius - 0.6F - 0.16F * turbulence(torn * 4.0F, 6);
    const float gas = 1.0F / (1.0F + std::exp(50.0F * hull));
    // Sheets lie where turbulence is zero, and near the hull most of all.
    const float sheet = std::exp(-std::abs(turbulence(torn * 5.0F + Place{3, 1, 4}, 5)) * 14.0F);
    const float near = std::exp(-hull * hull * 30.0F);
    return std::clamp(gas * (0.18F + 0.25F * near + 0.57F * sheet * (0.3F + 0.7F * near)), 0.0F, 1.0F);
}

}  // namespace mote::bench
