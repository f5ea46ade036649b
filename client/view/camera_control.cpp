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
constexpr double closest = 1e-9, farthest = 1e6;  // distances and heights, world units

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

Camera orbit(const Camera& camera, glm::dvec2 drag, const glm::dvec3& about) {
    const glm::dvec3 up = glm::normalize(camera.up), arm = camera.eye - camera.target;
    const glm::dvec3 right = glm::normalize(glm::cross(up, arm));
    const double polar = std::acos(std::clamp(glm::dot(glm::normalize(arm), up), -1.0, 1.0));
    constexpr double pole = 0.02;  // rad from the pole, where "up" would lose its meaning
    const double wanted = std::clamp(polar - drag.y * glm::pi<double>(), pole, glm::pi<double>() - pole);
    const auto turned = [&](const glm::dvec3& vector) {
        return rotated(rotated(vector, wanted - polar, right), -drag.x * glm::pi<double>(), up);
    };
    Camera moved = camera;
    moved.target = about + turned(camera.target - about);
    moved.eye = moved.target + turned(arm);
    return moved;
}

Camera roll(const Camera& camera, double radians) {
    Camera rolled = camera;
    const glm::dvec3 sight = glm::normalize(camera.target - camera.eye);
    const glm::dvec3 right = glm::normalize(glm::cross(sight, camera.up));
    rolled.up = rotated(glm::cross(right, sight), radians, sight);
    return rolled;
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

Camera dolly(const Camera& camera, double steps, const glm::dvec3& to) {
    const double span =
        camera.perspective() ? glm::distance(camera.eye, camera.target) : *camera.orthographicHeight;
    const double least = camera.perspective() ? std::max(closest, 4.0 * leastSight(to)) : closest;
    const double factor = scaled(span, steps, least, farthest) / span;
    Camera moved = camera;
    moved.target = to + (camera.target - to) * factor;
    const glm::dvec3 arm = camera.eye - camera.target;
    moved.eye = moved.target + (camera.perspective() ? arm * factor : arm);
    if (!camera.perspective()) moved.orthographicHeight = span * factor;
    return moved;
}

Sight sightAt(const Camera& camera, double aspect, glm::dvec2 at) {
    const glm::dvec3 ahead = glm::normalize(camera.target - camera.eye);
    const glm::dvec3 right = glm::normalize(glm::cross(ahead, camera.up)), up = glm::cross(right, ahead);
    const double h = camera.halfHeight();
    const glm::dvec3 aside = (2.0 * at.x - 1.0) * aspect * h * right + (1.0 - 2.0 * at.y) * h * up;
    return camera.perspective() ? Sight{camera.eye, ahead + aside} : Sight{camera.eye + aside, ahead};
}

std::optional<glm::dvec2> seenAt(const Camera& camera, double aspect, const glm::dvec3& place) {
    const auto seen = camera.worldToEye() * glm::dvec4(place, 1.0);
    const double depth = camera.perspective() ? -seen.z : 1.0, half = camera.halfHeight() * depth;
    if (!(depth > 0.0)) return std::nullopt;
    return glm::dvec2(0.5 + 0.5 * seen.x / (aspect * half), 0.5 - 0.5 * seen.y / half);
}

glm::dvec3 placeAt(const Camera& camera, double aspect, glm::dvec2 at) {
    const auto sight = sightAt(camera, aspect, at);
    return sight.from + sight.along * glm::distance(camera.eye, camera.target);
}

std::optional<glm::dvec3> placeWithin(const Camera& camera, double aspect, glm::dvec2 at, const Bounds& box) {
    const auto sight = sightAt(camera, aspect, at);
    double begin = camera.perspective() ? nearShare * glm::distance(camera.eye, camera.target) : -farthest;
    double end = farthest;
    for (int axis = 0; axis < 3; ++axis) {
        const double one = (box.min[axis] - sight.from[axis]) / sight.along[axis];
        const double other = (box.max[axis] - sight.from[axis]) / sight.along[axis];
        if (std::isnan(one) || std::isnan(other)) return std::nullopt;  // along a side
        begin = std::max(begin, std::min(one, other));
        end = std::min(end, std::max(one, other));
    }
    if (!(begin < end)) return std::nullopt;
    return sight.from + sight.along * (0.5 * (begin + end));
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

Camera fitAlong(const Camera& camera, const Camera& fitted) {
    Camera along = camera;
    along.target = fitted.target;
    along.eye =
        fitted.target + glm::normalize(camera.eye - camera.target) * glm::distance(fitted.eye, fitted.target);
    along.fovYDegrees = fitted.fovYDegrees;
    if (!camera.perspective()) along.orthographicHeight = heightAtTarget(fitted);
    return along;
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
