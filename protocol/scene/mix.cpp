// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/mix.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace mote {
namespace {

/// A unit vector at a right angle to one.
glm::dvec3 acrossFrom(const glm::dvec3& unit) {
    const bool alongX = std::abs(unit.x) > 0.9;
    const glm::dvec3 other = alongX ? glm::dvec3(0.0, 1.0, 0.0) : glm::dvec3(1.0, 0.0, 0.0);
    return glm::normalize(glm::cross(unit, other));
}

}  // namespace

glm::dvec3 mixDirections(const glm::dvec3& from, const glm::dvec3& to, double share) {
    if (from == to || share <= 0.0) return from;
    if (share >= 1.0) return to;
    const glm::dvec3 aside = to - glm::dot(from, to) * from;
    const double sine = glm::length(aside), cosine = glm::dot(from, to);
    const double angle = share * std::atan2(sine, cosine);
    const glm::dvec3 across = sine > 1e-9 ? aside / sine : acrossFrom(from);
    return glm::normalize(std::cos(angle) * from + std::sin(angle) * across);
}

}  // namespace mote
