// SPDX-License-Identifier: GPL-3.0-or-later
//
// FieldLight: what a light makes of the colour of a field's matter where that has a normal (docs/PICTURE.md,
// "Hybrid volumes", "Light"). A value.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "protocol/scene/light.h"
#include "server/render/plan/field_plan.h"

namespace mote::render {

class FieldLight {
  public:
    /// `worldToEye`: of a fixed light. `silhouettes`: how much darker is what turns away from the eye, 0
    /// to 1.
    FieldLight(const Light& light, const glm::dmat4& worldToEye, double silhouettes)
        : light_(light), silhouettes_(silhouettes) {
        towards_ = glm::normalize(light.fixed ? glm::dmat3(worldToEye) * light.direction : light.direction);
        const glm::dvec3 sum = towards_ + glm::dvec3(0.0, 0.0, 1.0);
        half_ = glm::length(sum) > 1e-9 ? glm::normalize(sum) : glm::dvec3(0.0);
    }

    /// Where there is no normal.
    Shade flat() const { return {held(light_.ambient + light_.diffuse), 0.0F}; }
    /// `n`: eye space, unit.
    Shade of(const glm::dvec3& n) const {
        const double diffuse = twoSided(n.z, glm::dot(n, towards_), [](double x) { return x; });
        const double specular = twoSided(n.z, glm::dot(n, half_), [](double x) { return std::pow(x, 32.0); });
        const double away = 1.0 - std::abs(n.z), left = 1.0 - silhouettes_ * away * away;
        return {static_cast<float>(left * std::min(light_.ambient + light_.diffuse * diffuse, 1.0)),
                static_cast<float>(left * light_.specular * specular)};
    }

  private:
    static float held(double x) { return static_cast<float>(std::min(x, 1.0)); }
    /// The mean of the terms of n and of -n, weighted by how far n is turned to the eye.
    template <class Term>
    static double twoSided(double towardsEye, double cosine, const Term& term) {
        const double x = std::clamp(2.0 * towardsEye + 0.5, 0.0, 1.0);
        const double front = x * x * (3.0 - 2.0 * x);
        return front * term(std::max(0.0, cosine)) + (1.0 - front) * term(std::max(0.0, -cosine));
    }

    Light light_;
    double silhouettes_;
    glm::dvec3 towards_, half_;  // eye space, unit
};

}  // namespace mote::render
