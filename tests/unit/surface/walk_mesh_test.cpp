// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/stipple/surface/walk_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "tests/support/surface_measures.h"
#include "tests/unit/surface/test_surfaces.h"

namespace mote::test {
namespace {

prep::SurfacePoint placeOn(const TestSurface& surface, const glm::vec3& near) {
    const auto found = NearestTriangle(*surface.mesh).find(near);
    return {found.position, found.triangle};
}

TEST(WalkMesh, OnAPlaneItGoesStraight) {
    const TestSurface plane(square(0.0F));
    const auto from = placeOn(plane, {0.11F, 0.23F, 0.0F});
    const glm::dvec3 step(0.7, 0.61, 0.0);
    const auto to = plane.walk->walk(from, step);
    EXPECT_LT(glm::distance(to.position, from.position + step), 1e-12);
    EXPECT_LT(NearestTriangle(*plane.mesh).find(glm::vec3(to.position)).distance, 1e-7);
}

TEST(WalkMesh, ItEndsAtABorder) {
    const TestSurface plane(square(0.0F));
    const auto to = plane.walk->walk(placeOn(plane, {0.5F, 0.3F, 0.0F}), {4.0, 0.0, 0.0});
    EXPECT_NEAR(to.position.x, 1.0, 1e-12);
    EXPECT_NEAR(to.position.y, 0.3, 1e-7);
}

TEST(WalkMesh, AroundAPrismItKeepsItsLength) {
    // A developable surface: walking once around a prism of 36 sides at a right angle to its axis leads back.
    constexpr int sides = 36;
    const TestSurface prism(gridMesh(sides, 4, [](float u, float v) {
        const double a = 2.0 * std::numbers::pi * (u < 1.0F ? u : 0.0F);
        return glm::vec3(std::cos(a), std::sin(a), v);
    }));
    const auto from = placeOn(prism, {1.0F, 0.01F, 0.4F});
    const double around = sides * 2.0 * std::sin(std::numbers::pi / sides);
    const auto to = prism.walk->walk(from, {0.0, around, 0.0});
    // Corners are rounded to floats, so each side is off by some 1e-7.
    EXPECT_LT(glm::distance(to.position, from.position), 1e-5);
}

TEST(WalkMesh, OnASphereItFollowsAGreatCircle) {
    const TestSurface ball(sphere(6));
    const auto from = placeOn(ball, {1.0F, 0.02F, 0.03F});
    const auto to = ball.walk->walk(from, {0.0, 0.0, 1.0});
    // An angle of 1, from one of 0.03. Triangles of edge 0.025 lie up to 1e-4 below the sphere, and
    // straightest geodesics turn a little at each edge.
    EXPECT_NEAR(std::asin(to.position.z / glm::length(to.position)), 1.03, 0.01);
}

TEST(WalkMesh, NormalsAreSmoothButAtCreases) {
    const TestSurface ball(sphere(5));
    for (const auto& place : {glm::vec3(0.3F, 0.8F, 0.5F), glm::vec3(-0.6F, 0.1F, -0.7F)}) {
        const auto point = placeOn(ball, place);
        EXPECT_GT(glm::dot(ball.walk->normalAt(point), glm::normalize(point.position)), 0.9999);
    }
}

}  // namespace
}  // namespace mote::test
