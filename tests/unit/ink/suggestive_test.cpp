// SPDX-License-Identifier: GPL-3.0-or-later
//
// Suggestive contours against a torus, whose curvature is known: each lies where its radial curvature is zero
// and grows towards the eye, and none is missing that is plain.
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "server/render/layers/ink/mesh_lines.h"
#include "tests/support/generated_mesh.h"
#include "tests/support/random.h"
#include "tests/unit/ink/ink_views.h"

namespace mote::render {
namespace {

constexpr double around = 1.0, tube = 0.45;  // radii

/// Around the axis z, and around the tube.
struct OnTorus {
    double turn, roll;

    double fromAxis() const { return around + tube * std::cos(roll); }
    glm::dvec3 place() const {
        return {fromAxis() * std::cos(turn), fromAxis() * std::sin(turn), tube * std::sin(roll)};
    }
    glm::dvec3 normal() const {
        return {std::cos(roll) * std::cos(turn), std::cos(roll) * std::sin(turn), std::sin(roll)};
    }
    glm::dvec3 along() const { return {-std::sin(turn), std::cos(turn), 0.0}; }
    glm::dvec3 across() const {
        return {-std::sin(roll) * std::cos(turn), -std::sin(roll) * std::sin(turn), std::cos(roll)};
    }
    glm::dvec3 towards(const glm::dvec3& eye) const {
        const glm::dvec3 way = glm::normalize(eye - place());
        return way - glm::dot(way, normal()) * normal();
    }
    double cosine(const glm::dvec3& eye) const { return glm::dot(glm::normalize(eye - place()), normal()); }
    /// Of a circle of the tube 1 / tube; of one around the axis cos(roll) / fromAxis().
    double radialCurvature(const glm::dvec3& eye) const {
        const glm::dvec3 way = towards(eye);
        const double u = glm::dot(way, along()), v = glm::dot(way, across());
        return (v * v / tube + u * u * std::cos(roll) / fromAxis()) / (u * u + v * v);
    }
    OnTorus moved(const glm::dvec3& way) const {
        return {turn + glm::dot(way, along()) / fromAxis(), roll + glm::dot(way, across()) / tube};
    }
    /// By finite differences along the surface.
    double growth(const glm::dvec3& eye) const {
        constexpr double step = 1e-4;
        const glm::dvec3 way = step * glm::normalize(towards(eye));
        return (moved(way).radialCurvature(eye) - moved(-way).radialCurvature(eye)) / (2.0 * step);
    }
};

OnTorus nearest(const glm::dvec3& place) {
    const double axis = std::hypot(place.x, place.y);
    return {std::atan2(place.y, place.x), std::atan2(place.z, axis - around)};
}

storage::SurfaceMesh torus(std::uint32_t turns, std::uint32_t rolls) {
    storage::SurfaceMesh mesh;
    for (std::uint32_t i = 0; i < turns; ++i) {
        for (std::uint32_t k = 0; k < rolls; ++k) {
            const OnTorus at{2.0 * std::numbers::pi * i / turns, 2.0 * std::numbers::pi * k / rolls};
            mesh.positions.emplace_back(at.place());
            mesh.normals.emplace_back(at.normal());
            const auto number = [&](std::uint32_t a, std::uint32_t b) {
                return (a % turns) * rolls + b % rolls;
            };
            mesh.triangles.push_back({number(i, k), number(i + 1, k), number(i + 1, k + 1)});
            mesh.triangles.push_back({number(i, k), number(i + 1, k + 1), number(i, k + 1)});
        }
    }
    return mesh;
}

TEST(SuggestiveLines, LieWhereATorusHasThem) {
    const auto surface = test::surfaceOf(torus(360, 180));
    test::Random random(3);
    std::size_t found = 0, sought = 0;
    for (int i = 0; i < 6; ++i) {
        Camera camera = fitCamera(surface->bounds(), 1.0);
        camera.eye = camera.target + 5.0 * random.direction();
        const LineView view(test::planOf(camera, 400, 400), glm::dmat4(1.0));
        const auto lines = suggestiveLines(*surface, view, {});
        std::vector<glm::dvec3> places;
        for (const auto& line : lines) {
            EXPECT_EQ(line.kind, LineKind::suggestive);
            for (const auto& end : line.ends) {
                const OnTorus at = nearest(end);
                // An edge is at most .035 long, on which the curvature changes by at most some 10 a unit:
                // half of the way off as a place is between ends.
                EXPECT_LT(std::abs(at.radialCurvature(camera.eye)), 0.1) << i;
                // Behind, where nothing hides it, it would be seen from inside.
                EXPECT_GT(std::copysign(1.0, at.cosine(camera.eye)) * at.growth(camera.eye), 0.0) << i;
                places.push_back(end);
            }
        }
        found += lines.size();
        // What is plain: grows twice as fast as it must, and is seen neither flat nor from before.
        constexpr int side = 160;
        for (int k = 0; k < side * side; ++k) {
            const OnTorus at{2.0 * std::numbers::pi * (k % side) / side,
                             2.0 * std::numbers::pi * (k / side) / side};
            const double cosine = at.cosine(camera.eye), growth = at.growth(camera.eye);
            const double usual = std::hypot(1.0 / tube, 1.0);  // more than the median curvature
            if (cosine < 0.15 || cosine > 0.85 || growth < 1.5 * usual * usual * cosine ||
                std::abs(at.radialCurvature(camera.eye)) > 0.02 * growth)
                continue;
            ++sought;
            double least = HUGE_VAL;
            for (const auto& place : places) least = std::min(least, glm::distance(place, at.place()));
            EXPECT_LT(least, 0.06) << i << ' ' << cosine;
        }
    }
    EXPECT_GT(found, 500U);
    EXPECT_GT(sought, 20U);
}

/// A surface that bends away from the eye everywhere has none.
TEST(SuggestiveLines, AreNotOnABall) {
    const auto surface = test::surfaceOf(test::meshOf("sphere", 0, 0)->mesh());
    const LineView view(test::planOf(fitCamera(surface->bounds(), 1.0), 200, 200), glm::dmat4(1.0));
    EXPECT_TRUE(suggestiveLines(*surface, view, {}).empty());
}

/// Seen from inside a surface turned inside out is the same surface.
TEST(SuggestiveLines, DoNotDependOnWhichSideIsOutside) {
    auto mesh = torus(120, 60);
    const Camera camera = [&] {
        Camera made = fitCamera(test::surfaceOf(mesh)->bounds(), 1.0);
        made.eye = made.target + glm::dvec3(2.0, 3.0, 3.0);
        return made;
    }();
    const LineView view(test::planOf(camera, 200, 200), glm::dmat4(1.0));
    const auto length = [&](const storage::SurfaceMesh& of) {
        double sum = 0.0;
        for (const auto& line : suggestiveLines(*test::surfaceOf(of), view, {})) {
            if (nearest(line.ends[0]).cosine(camera.eye) > 0.0)
                sum += glm::distance(line.ends[0], line.ends[1]);
        }
        return sum;
    };
    auto turned = mesh;
    for (auto& normal : turned.normals) normal = -normal;
    for (auto& corners : turned.triangles) std::swap(corners[1], corners[2]);
    EXPECT_GT(length(mesh), 0.2);
    EXPECT_NEAR(length(turned), length(mesh), 1e-6 * length(mesh));
}

}  // namespace
}  // namespace mote::render
