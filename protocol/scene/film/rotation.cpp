// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/film/rotation.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace mote {

glm::dquat rotationBy(const glm::dvec3& vector) {
    const double angle = glm::length(vector);
    const double scale = angle > 1e-12 ? std::sin(0.5 * angle) / angle : 0.5;
    return {std::cos(0.5 * angle), scale * vector.x, scale * vector.y, scale * vector.z};
}

glm::dvec3 rotationVector(const glm::dquat& rotation) {
    const glm::dvec3 vector(rotation.x, rotation.y, rotation.z);
    const double sine = glm::length(vector);
    // Towards a whole turn the axis is lost; no way between neighbours goes so far.
    const double scale = sine > 1e-12 ? 2.0 * std::atan2(sine, rotation.w) / sine : 2.0;
    return scale * vector;
}

glm::dquat nearerTo(const glm::dquat& other, const glm::dquat& rotation) {
    return glm::dot(other, rotation) < 0.0 ? -rotation : rotation;
}

glm::dquat mixRotations(const glm::dquat& from, const glm::dquat& to, double share) {
    return glm::normalize(from * rotationBy(share * rotationVector(glm::conjugate(from) * to)));
}

glm::dquat RotationWay::operator()(double share) const {
    const auto a = mixRotations(from, leaving, share), b = mixRotations(leaving, arriving, share);
    const auto c = mixRotations(arriving, to, share);
    return mixRotations(mixRotations(a, b, share), mixRotations(b, c, share), share);
}

}  // namespace mote
