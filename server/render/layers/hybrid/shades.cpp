// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/hybrid/shades.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "storage/hybrid/normal_table.h"

namespace mote::render {
namespace {

/// The mean of the terms of n and of -n, weighted by how far n is turned to the eye.
template <class Term>
double twoSided(double towardsEye, double cosine, const Term& term) {
    const double x = std::clamp(2.0 * towardsEye + 0.5, 0.0, 1.0);
    const double front = x * x * (3.0 - 2.0 * x);
    return front * term(std::max(0.0, cosine)) + (1.0 - front) * term(std::max(0.0, -cosine));
}

}  // namespace

Shades shadesOf(const Light& light, const glm::dmat4& layerToEye, const glm::dmat4& worldToEye) {
    Shades shades;
    static const storage::NormalTable normals;
    // Normals go by the inverse transpose.
    const glm::dmat3 toEye = glm::transpose(glm::inverse(glm::dmat3(layerToEye)));
    const glm::dvec3 towards =
        glm::normalize(light.fixed ? glm::dmat3(worldToEye) * light.direction : light.direction);
    const glm::dvec3 sum = towards + glm::dvec3(0.0, 0.0, 1.0);
    const glm::dvec3 half = glm::length(sum) > 1e-9 ? glm::normalize(sum) : glm::dvec3(0.0);
    const auto held = [](double x) { return static_cast<float>(std::min(x, 1.0)); };
    shades.fill({held(light.ambient + light.diffuse), 0.0F});
    for (int code = 0; code < 256; ++code) {
        const glm::dvec3 normal(normals.direction(static_cast<std::uint8_t>(code)));
        if (!(glm::length(normal) > 0.0)) continue;
        const glm::dvec3 n = glm::normalize(toEye * normal);
        const double diffuse = twoSided(n.z, glm::dot(n, towards), [](double x) { return x; });
        const double specular = twoSided(n.z, glm::dot(n, half), [](double x) { return std::pow(x, 32.0); });
        shades[static_cast<std::size_t>(code)] = {held(light.ambient + light.diffuse * diffuse),
                                                  static_cast<float>(light.specular * specular)};
    }
    return shades;
}

}  // namespace mote::render
