// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/views/random_places.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

namespace mote::test {
namespace {

glm::dmat3 anyRotation(Random& random) {
    const glm::dvec3 axis = random.direction();
    // The quarter turns are those that bring a side of the box into the line of sight.
    if (random.chance(0.2)) return glm::dmat3(glm::dquat(std::sqrt(0.5), std::sqrt(0.5), 0.0, 0.0));
    const double real = random.between(-1.0, 1.0);
    return glm::dmat3(glm::normalize(glm::dquat(real, axis.x, axis.y, axis.z)));
}

/// Turned, and in some cases mirrored, of uneven scale or sheared.
glm::dmat3 anyShape(Random& random) {
    glm::dmat3 shape(1.0);
    if (random.chance(0.3)) return shape;
    if (random.chance(0.3)) {
        for (int axis = 0; axis < 3; ++axis) shape[axis][axis] = random.magnitude(-3, 1);
    }
    if (random.chance(0.3)) {
        for (int axis = 1; axis < 3; ++axis) shape[axis][0] = random.between(-1.0, 1.0);
    }
    if (random.chance(0.25)) shape[static_cast<int>(random.below(3))] *= -1.0;
    return random.chance(0.7) ? anyRotation(random) * shape : shape;
}

/// The layer's box as large as `size` along its longest edge, around `center`.
glm::dmat4 placed(const glm::dmat3& shape, const Bounds& bounds, double size, const glm::dvec3& center) {
    const glm::dvec3 edges = bounds.size();
    const double scale = size / std::max({edges.x, edges.y, edges.z});
    glm::dmat4 transform(scale * shape);
    transform[3] = glm::dvec4(center - scale * (shape * bounds.center()), 1.0);
    return transform;
}

/// What a view accepts (protocol/scene/view.cpp).
bool sensible(const glm::dmat4& transform) {
    const double determinant = std::abs(glm::determinant(glm::dmat3(transform)));
    return determinant > 1e-17 && determinant < 1e17;
}

/// How the sizes and places of a view's layers go together.
struct World {
    bool asTheyAre;     ///< without transforms: a CT of 250 units beside a beam of 2
    double size;        ///< of all of it
    int spread;         ///< sizes differ by up to so many powers of two, either way
    glm::dvec3 origin;  ///< far away from it, places have few digits left
};

World anyWorld(Random& random) {
    World world{random.chance(0.15), 2.0, 1, glm::dvec3(0.0)};
    if (random.chance(0.2)) world.size = random.magnitude(-19, 19);
    if (random.chance(0.3)) world.spread = random.chance(0.5) ? 4 : 9;
    if (random.chance(0.1)) world.spread = 18;
    if (random.chance(0.1)) world.origin = world.size * random.magnitude(0, 12) * glm::dvec3(1.0, -0.5, 0.25);
    return world;
}

glm::dmat4 anyTransform(Random& random, const World& world, const Bounds& bounds) {
    const double size = world.size * random.magnitude(-world.spread, world.spread);
    const glm::dmat3 shape = anyShape(random);
    const double away = random.chance(0.5) ? 0.25 * size : 0.5 * std::max(size, world.size);
    const glm::dvec3 center = world.origin + away * random.direction();
    const glm::dmat4 transform = placed(shape, bounds, size, center);
    return sensible(transform) ? transform : glm::dmat4(1.0);
}

}  // namespace

std::vector<glm::dmat4> anyTransforms(Random& random, const std::vector<Bounds>& layers) {
    const World world = anyWorld(random);
    std::vector<glm::dmat4> transforms;
    for (const auto& bounds : layers)
        transforms.push_back(world.asTheyAre ? glm::dmat4(1.0) : anyTransform(random, world, bounds));
    return transforms;
}

}  // namespace mote::test
