// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/views/random_camera.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace mote::test {
namespace {

double anyAngle(Random& random) {
    if (random.chance(0.2)) return random.oneOf({0.1, 1.0, 120.0, 179.0});
    return random.between(15.0, 75.0);
}

/// Along an axis in some cases, so that sides are seen edge on.
glm::dvec3 anySide(Random& random) {
    if (!random.chance(0.15)) return random.direction();
    glm::dvec3 side(0.0);
    side[static_cast<int>(random.below(3))] = random.sign();
    return side;
}

/// How far off what is `radius` large fills the picture.
double fillingDistance(const Camera& camera, double radius) {
    return radius / std::tan(0.5 * camera.fovYDegrees * 3.14159265358979 / 180.0);
}

void standAround(Random& random, const Bounds& content, Camera& camera) {
    const double radius = 0.5 * glm::length(content.size());
    const glm::dvec3 side = anySide(random);
    const double aside = 0.3 * radius * random.unit();
    camera.target = content.center() + aside * random.direction();
    const double distance = fillingDistance(camera, radius) * random.between(0.35, 1.5);
    camera.eye = camera.target + std::max(distance, 0.01 * radius) * side;
}

void standInside(Random& random, const Bounds& content, Camera& camera) {
    const double x = random.unit(), y = random.unit(), z = random.unit();
    camera.eye = content.min + content.size() * glm::dvec3(x, y, z);
    const double sight = glm::length(content.size()) * random.magnitude(-8, 6);
    camera.target = camera.eye + sight * anySide(random);
}

/// All of it, or all but a corner, lies behind the eye.
void lookAway(Random& random, const Bounds& content, Camera& camera) {
    standAround(random, content, camera);
    camera.target = camera.eye + (camera.eye - camera.target);
}

/// As small as a pixel, or through a telescope.
void standFarAway(Random& random, const Bounds& content, Camera& camera) {
    standAround(random, content, camera);
    if (random.chance(0.6)) camera.fovYDegrees = 0.1;
    const double distance = fillingDistance(camera, glm::length(content.size())) * random.magnitude(-2, 4);
    camera.eye = camera.target + distance * random.direction();
}

/// The eye lies in the plane of a side of the box.
void lookAlong(Random& random, const Bounds& content, Camera& camera) {
    standAround(random, content, camera);
    const int axis = static_cast<int>(random.below(3));
    camera.eye[axis] = camera.target[axis] = random.chance(0.5) ? content.min[axis] : content.max[axis];
}

void setUp(Random& random, Camera& camera) {
    if (random.chance(0.4)) return;
    camera.up = random.chance(0.5) ? glm::dvec3(0.0, 0.0, 1.0) : random.direction();
    // Nearly along the line of sight.
    if (random.chance(0.1))
        camera.up = glm::normalize(camera.target - camera.eye) + 1e-4 * random.direction();
    if (random.chance(0.2)) camera.up *= random.magnitude(-10, 10);
}

}  // namespace

Camera anyCamera(Random& random, const Bounds& content) {
    Camera camera;
    camera.fovYDegrees = anyAngle(random);
    const double how = random.unit();
    if (how < 0.7) {
        standAround(random, content, camera);
    } else if (how < 0.82) {
        standInside(random, content, camera);
    } else if (how < 0.87) {
        lookAway(random, content, camera);
    } else if (how < 0.94) {
        standFarAway(random, content, camera);
    } else {
        lookAlong(random, content, camera);
    }
    setUp(random, camera);
    if (random.chance(0.25)) {
        const double height = glm::length(content.size()) * random.between(0.25, 1.5);
        camera.orthographicHeight = random.chance(0.85) ? height : height * random.magnitude(-9, 9);
    }
    return camera;
}

}  // namespace mote::test
