// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/frustum.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <random>

namespace mote::render {
namespace {

constexpr double width = 320;
constexpr double height = 180;

/// Whether a point's centre lies in the picture widened by `margin` pixels: docs/PICTURE.md, once more.
bool seen(const Camera& camera, const glm::dmat4& layerToEye, const glm::dvec3& point, double margin,
          double nearDepth) {
    const glm::dvec3 eye(layerToEye * glm::dvec4(point, 1.0));
    const double depth = -eye.z;
    if (camera.perspective() && depth < nearDepth) return false;
    const double scale = camera.perspective() ? depth : 1.0;
    const double h = camera.halfHeight() * scale;
    const double x = (eye.x / (h * width / height) + 1.0) * 0.5 * width;
    const double y = (1.0 - eye.y / h) * 0.5 * height;
    return x >= -margin && x <= width + margin && y >= -margin && y <= height + margin;
}

class FrustumTest : public testing::TestWithParam<bool> {
  protected:
    Camera camera(const glm::dvec3& eye, const glm::dvec3& target) const {
        Camera result;
        result.eye = eye;
        result.target = target;
        if (GetParam()) result.orthographicHeight = 0.7;
        return result;
    }
};

TEST_P(FrustumTest, NeverHidesWhatIsSeenAndKnowsWhatIsInside) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> even(-1.0, 1.0);
    int outside = 0, inside = 0;
    for (int i = 0; i < 3000; ++i) {
        const auto look =
            camera({even(random), even(random), 1.5 * even(random)}, {even(random), even(random), 3.0});
        const glm::dmat4 toEye = look.worldToEye();
        const double margin = i % 2 == 0 ? 0.0 : 20.0;
        const Frustum frustum(look, width, height, margin, 0.05, toEye);
        const glm::dvec3 center(even(random), even(random), even(random));
        const double half = 0.02 + 0.2 * std::abs(even(random));
        const auto side = frustum.of(center, half);
        outside += side == Frustum::Side::outside;
        inside += side == Frustum::Side::inside;
        for (int k = 0; k < 20; ++k) {
            const glm::dvec3 point = center + half * glm::dvec3(even(random), even(random), even(random));
            const bool visible = seen(look, toEye, point, margin, 0.05);
            EXPECT_NE(side, visible ? Frustum::Side::outside : Frustum::Side::inside);
        }
    }
    // The cases are mixed: neither answer came for free.
    EXPECT_GT(outside, 300);
    EXPECT_GT(inside, 30);
}

TEST_P(FrustumTest, BehindTheEyeOnlyAnOrthographicCameraSees) {
    const auto look = camera({0, 0, 0}, {0, 0, -1});
    const Frustum frustum(look, width, height, 0.0, 1e-3, look.worldToEye());
    EXPECT_EQ(frustum.of({0, 0, -0.5}, 0.01), Frustum::Side::inside);
    EXPECT_EQ(frustum.of({0, 0, 0.5}, 0.01), GetParam() ? Frustum::Side::inside : Frustum::Side::outside);
}

INSTANTIATE_TEST_SUITE_P(Cameras, FrustumTest, testing::Values(false, true),
                         [](const auto& which) { return which.param ? "orthographic" : "perspective"; });

}  // namespace
}  // namespace mote::render
