// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/film/legal_camera.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

namespace mote {
namespace {

constexpr double worldLimit = 1e12;   // of a coordinate: parseCamera
constexpr double leastHeight = 1e-9;  // of a parallel projection

}  // namespace

glm::dquat orientationOf(const Camera& camera) {
    return glm::normalize(glm::quat_cast(glm::transpose(glm::dmat3(camera.worldToEye()))));
}

Camera placed(Camera camera, const glm::dvec3& target, const glm::dvec3& offset) {
    camera.target = glm::clamp(target, -0.4 * worldLimit, 0.4 * worldLimit);
    const double distance = glm::length(offset);
    const double least = 2.0 * leastSight(camera.target);
    const double legal = std::clamp(distance, least, 0.4 * worldLimit);
    camera.eye = camera.target + (legal == distance ? offset : (legal / distance) * offset);
    camera.fovYDegrees = std::clamp(camera.fovYDegrees, leastFovYDegrees, mostFovYDegrees);
    if (!camera.orthographicHeight) return camera;
    camera.orthographicHeight = std::clamp(*camera.orthographicHeight, leastHeight, worldLimit);
    return camera;
}

Camera standing(Camera camera, const glm::dvec3& target, const glm::dquat& orientation, double distance) {
    camera.up = orientation * glm::dvec3(0.0, 1.0, 0.0);
    // A distance may be too small or too large for the number itself.
    const double some = std::clamp(distance, 1e-30, 1e30);
    return placed(camera, target, some * (orientation * glm::dvec3(0.0, 0.0, 1.0)));
}

}  // namespace mote
