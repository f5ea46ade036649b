// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/camera_control.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/trigonometric.hpp>

namespace mote::client {
namespace {

constexpr double stepFactor = 0.9;                // what a tenth of the way leaves
constexpr double closest = 1e-6, farthest = 1e6;  // distances and heights, world units

glm::dvec3 rotated(const glm::dvec3& vector, double angle, const glm::dvec3& axis) {
    return glm::dvec3(glm::rotate(glm::dmat4(1.0), angle, axis) * glm::dvec4(vector, 0.0));
}

/// World units across the picture's height in the target's plane.
double heightAtTarget(const Camera& camera) {
    return 2.0 * camera.halfHeight() *
           (camera.perspective() ? glm::distance(camera.eye, camera.target) : 1.0);
}

double scaled(double value, double steps, double least, double greatest) {
    return std::clamp(value * std::pow(stepFactor, steps), least, greatest);
}

}  // namespace

Camera orbit(const Camera& camera, glm::dvec2 drag) {
    const glm::dvec3 up = glm::normalize(camera.up);
    glm::dvec3 arm = rotated(camera.eye - camera.target, -drag.x * glm::pi<double>(), up);
    const glm::dvec3 right = glm::normalize(glm::cross(up, arm));
    const double polar = std::acos(std::clamp(glm::dot(glm::normalize(arm), up), -1.0, 1.0));
    constexpr double pole = 0.02;  // rad from the pole, where "up" would lose its meaning
    const double wanted = std::clamp(polar - drag.y * glm::pi<double>(), pole, glm::pi<double>() - pole);
    arm = rotated(arm, wanted - polar, right);
    Camera turned = camera;
    turned.eye = camera.target + arm;
    return turned;
}

Camera pan(const Camera& camera, glm::dvec2 drag) {
    const glm::dvec3 sight = glm::normalize(camera.target - camera.eye);
    const glm::dvec3 right = glm::normalize(glm::cross(sight, camera.up));
    const glm::dvec3 up = glm::cross(right, sight);
    const glm::dvec3 offset = heightAtTarget(camera) * (-drag.x * right + drag.y * up);
    Camera moved = camera;
    moved.eye += offset;
    moved.target += offset;
    return moved;
}

Camera dolly(const Camera& camera, double steps) {
    if (!camera.perspective()) return zoom(camera, steps);
    const double distance = glm::distance(camera.eye, camera.target);
    const glm::dvec3 arm = (camera.eye - camera.target) / distance;
    Camera moved = camera;
    moved.eye = camera.target + arm * scaled(distance, steps, closest, farthest);
    return moved;
}

Camera zoom(const Camera& camera, double steps) {
    Camera zoomed = camera;
    if (camera.perspective()) {
        zoomed.fovYDegrees = scaled(camera.fovYDegrees, steps, 0.5, 140.0);
    } else {
        zoomed.orthographicHeight = scaled(*camera.orthographicHeight, steps, closest, farthest);
    }
    return zoomed;
}

Camera lookFrom(const Camera& camera, int axis, bool positive) {
    Camera from = camera;
    glm::dvec3 away(0.0);
    away[axis] = positive ? 1.0 : -1.0;
    from.eye = camera.target + glm::distance(camera.eye, camera.target) * away;
    from.up = axis == 2 ? glm::dvec3(0.0, 1.0, 0.0) : glm::dvec3(0.0, 0.0, 1.0);
    return from;
}

Camera toggleProjection(const Camera& camera) {
    Camera other = camera;
    if (camera.perspective()) {
        other.orthographicHeight = heightAtTarget(camera);
        return other;
    }
    const double tangent = std::tan(glm::radians(0.5 * camera.fovYDegrees));
    const double distance = 0.5 * *camera.orthographicHeight / tangent;
    other.orthographicHeight.reset();
    other.eye = camera.target + glm::normalize(camera.eye - camera.target) * distance;
    return other;
}

}  // namespace mote::client
