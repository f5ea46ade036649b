// SPDX-License-Identifier: GPL-3.0-or-later
//
// Rotations as unit quaternions, and ways between them: Bezier curves by de Casteljau's construction with
// spherical interpolation (K. Shoemake, Animating rotation with quaternion curves, 1985). Pure functions.
#pragma once

#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace mote {

/// A rotation about a vector by its length, radians.
glm::dquat rotationBy(const glm::dvec3& vector);
/// The vector that rotationBy() takes for a unit quaternion: of q and -q, which rotate alike, different ones,
/// of length up to pi where q.w >= 0, and from pi to 2 pi else.
glm::dvec3 rotationVector(const glm::dquat& rotation);
/// Of q and -q the one nearer to another quaternion.
glm::dquat nearerTo(const glm::dquat& other, const glm::dquat& rotation);
/// At a share of the way along the great circle; not the shorter one, if they were not made the nearer ones.
glm::dquat mixRotations(const glm::dquat& from, const glm::dquat& to, double share);

/// A way from one rotation to another.
struct RotationWay {
    glm::dquat from, leaving, arriving, to;  ///< the four points of a cubic Bezier curve

    glm::dquat operator()(double share) const;
};

}  // namespace mote
