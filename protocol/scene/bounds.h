// SPDX-License-Identifier: GPL-3.0-or-later
//
// Bounds: an axis-aligned box, closed, in whatever space its owner says. A value.
#pragma once

#include <array>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

namespace mote {

struct Bounds {
    glm::dvec3 min;
    glm::dvec3 max;

    glm::dvec3 center() const { return 0.5 * (min + max); }
    glm::dvec3 size() const { return max - min; }
    std::array<glm::dvec3, 8> corners() const;
    /// The least box around both.
    Bounds united(const Bounds& other) const;
    /// The least box around this one's transformed corners.
    Bounds transformed(const glm::dmat4& transform) const;

    bool operator==(const Bounds&) const = default;
};

/// The box that every particle plot lies in, in layer space.
inline constexpr Bounds plotBounds{glm::dvec3(-1.0), glm::dvec3(1.0)};

}  // namespace mote
