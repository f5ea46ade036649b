// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>
#include <tbb/task_arena.h>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>

#include "server/render/layers/stipple/soft_points.h"
#include "server/render/layers/stipple/surface_dots.h"
#include "tests/support/ball_surface.h"
#include "tests/support/view_text.h"

namespace mote::render {
namespace {

using test::ballSurface;
using test::floorSurface;

/// The unit ball fills a circle of radius 150 pixels, seen without perspective from +z.
const std::string fromFront = "'eye': [0, 0, 4], 'target': [0, 0, 0], 'orthographicHeight': 2.6666667";

View ballView(const std::string& style, const std::string& camera = fromFront, double jitter = 0.0) {
    return test::viewOf("{'width': 400, 'height': 400, 'background': [0, 0, 0], 'camera': {" + camera +
                        "}, 'layers': [{'stipple': {'light': {'ambient': 1}, 'jitter': " +
                        std::to_string(jitter) + ", " + style + "}}]}");
}

struct Drawn {
    std::vector<ShownPoint> points;
    Dots dots;
};

Drawn draw(const StippleSurface& surface, const View& view, const glm::dmat4& transform = glm::dmat4(1.0)) {
    const SurfaceDots layer(surface, *view.layers[0].stipple(), view, transform);
    Drawn drawn;
    drawn.points = layer.seen(layer.chosen());
    drawn.dots = layer.onScreen(drawn.points);
    return drawn;
}

double distanceFromCentre(const Dot& dot) {
    return std::hypot(dot.x - 200.0, dot.y - 200.0);
}

TEST(SurfaceDots, AreEvenOnTheScreen) {
    const auto surface = ballSurface(60000);
    const auto drawn = draw(surface, ballView("'spacingPixels': 5"));
    // Twenty rings of equal area: each has as many dots. The test's points are even in height, and rings cut
    // through that at random: half of a Poisson deviation is allowed three times.
    const double wanted = std::numbers::pi * 150.0 * 150.0 * 2.0 / (std::numbers::sqrt3 * 25.0);
    std::vector<int> rings(20, 0);
    for (const auto& dot : drawn.dots) {
        const double share = std::pow(distanceFromCentre(dot) / 150.0, 2);
        ASSERT_LT(share, 1.0001);
        ++rings[std::min<std::size_t>(static_cast<std::size_t>(share * 20.0), 19)];
    }
    for (const int count : rings) EXPECT_NEAR(count, wanted / 20.0, 1.5 * std::sqrt(wanted / 20.0));
    EXPECT_NEAR(static_cast<double>(drawn.dots.size()), wanted, 0.01 * wanted);
}

TEST(SurfaceDots, PerspectiveIsEvenToo) {
    const auto surface = ballSurface(60000);
    // From 2 away the ball's circle has the tangent 1 / sqrt(3); half the picture is the tangent of 45
    // degrees.
    const auto drawn = draw(surface, ballView("'spacingPixels': 3.5",
                                              "'eye': [0, 0, 2], 'target': [0, 0, 0],"
                                              "'fovYDegrees': 90"));
    const double radius = 200.0 / std::numbers::sqrt3;
    const double wanted = std::numbers::pi * radius * radius * 2.0 / (std::numbers::sqrt3 * 12.25);
    std::vector<int> rings(10, 0);
    for (const auto& dot : drawn.dots) {
        const double share = std::pow(distanceFromCentre(dot) / radius, 2);
        ++rings[std::min<std::size_t>(static_cast<std::size_t>(share * 10.0), 9)];
    }
    // Ten rings of about 395 dots: two and a half deviations of a random count are 13%.
    for (const int count : rings) EXPECT_NEAR(count, wanted / 10.0, 2.5 * std::sqrt(wanted / 10.0));
}

TEST(SurfaceDots, NoneShinesThroughTheSurface) {
    const auto surface = ballSurface(30000);
    for (const std::string& camera : {fromFront, std::string("'eye': [1.5, 2, -1], 'target': [0.1, 0, 0]")}) {
        const View view = ballView("'spacingPixels': 3", camera);
        const auto drawn = draw(surface, view);
        ASSERT_GT(drawn.points.size(), 1000U);
        for (const auto& shown : drawn.points) {
            const glm::dvec3 normal(shown.position);
            const glm::dvec3 toEye =
                view.camera.perspective() ? view.camera.eye - normal : glm::dvec3(0, 0, 1);
            // The facets and the tolerance of the rays, both lengths off the surface, let a ray pass that
            // starts behind the ball's horizon by the square root of twice their sum.
            const double off = surface.tolerance() + 1.6e-4;
            EXPECT_GT(glm::dot(normal, glm::normalize(toEye)), -std::sqrt(2.0 * off));
        }
        const auto all = draw(surface, ballView("'spacingPixels': 3, 'seeThrough': true", camera));
        EXPECT_GT(all.points.size(), 3 * drawn.points.size() / 2);
    }
}

TEST(SurfaceDots, TheToneFollowsTheLight) {
    const auto surface = ballSurface(60000);
    const auto view = test::viewOf(
        "{'width': 400, 'height': 400, 'background': [0, 0, 0], 'camera': {'eye': [0, 0, 4], 'target': [0, "
        "0, 0], "
        "'orthographicHeight': "
        "2.6666667}, 'layers': [{'stipple': {'spacingPixels': 4, 'jitter': 0, 'light': {'direction': [1, 0, "
        "0],"
        "'ambient': 0.1, 'diffuse': 0.9}}}]}");
    int left = 0, right = 0;
    for (const auto& dot : draw(surface, view).dots) (dot.x < 200.0F ? left : right) += 1;
    // Of the half circle in the light, x / 150 has the mean 4 / (3 pi).
    const double half = 0.5 * std::numbers::pi * 150.0 * 150.0 * 2.0 / (std::numbers::sqrt3 * 16.0);
    EXPECT_NEAR(left, 0.1 * half, 0.02 * half);
    EXPECT_NEAR(right, (0.1 + 0.9 * 4.0 / (3.0 * std::numbers::pi)) * half, 0.02 * half);
}

TEST(SurfaceDots, AShadowLiesWhereTheLightIsHidden) {
    const auto surface = floorSurface(40000);
    const auto shaded = [&](const char* shadow) {
        const auto view = test::viewOf(
            std::string("{'width': 400, 'height': 400, 'background': [0, 0, 0], 'camera': {'eye': [0, 5, 0], "
                        "'target': [0, 0, 0], 'up': "
                        "[0, 0, -1], 'orthographicHeight': 4}, 'layers': [{'stipple': {'spacingPixels': 4, "
                        "'jitter': 0, 'light': {'direction': [1, 1, 0], 'fixed': true, 'ambient': 0, "
                        "'diffuse': 1, 'shadow': ") +
            shadow + "}}}]}");
        int inside = 0;
        // The ball's centre casts its shadow on (-1, -1, 0): 100 pixels left of the middle.
        for (const auto& dot : draw(surface, view).dots) {
            if (std::hypot(dot.x - 100.0, dot.y - 200.0) < 30.0) ++inside;
        }
        return inside;
    };
    EXPECT_GT(shaded("false"), 50);
    EXPECT_EQ(shaded("true"), 0);
}

TEST(SurfaceDots, TheSamePointStaysTheSameDot) {
    const auto surface = ballSurface(60000);
    const auto turned = [&](double degrees) {
        const double angle = degrees * std::numbers::pi / 180.0;
        View view = ballView("'spacingPixels': 5", fromFront, 0.5);
        view.camera.eye = {4.0 * std::sin(angle), 0.0, 4.0 * std::cos(angle)};
        const auto drawn = draw(surface, view);
        std::map<std::uint32_t, Dot> dots;
        for (std::size_t i = 0; i < drawn.dots.size(); ++i)
            dots.emplace(drawn.points[i].point, drawn.dots[i]);
        return dots;
    };
    const auto before = turned(0.0), after = turned(1.0);
    std::size_t stayed = 0;
    for (const auto& [point, dot] : after) {
        const auto found = before.find(point);
        if (found == before.end()) continue;
        ++stayed;
        // A degree moves the ball's surface by 150 pi / 180 = 2.6 pixels at most; the jitter, at most half of
        // the strength of the distance of dots on the surface, changes with the angle of view.
        EXPECT_LT(std::hypot(dot.x - found->second.x, dot.y - found->second.y), 2.7 + 2.5);
    }
    EXPECT_GT(stayed, after.size() * 9 / 10);
}

TEST(SurfaceDots, JitterMovesAlongTheEdgeOnly) {
    const auto surface = ballSurface(60000);
    const auto still = draw(surface, ballView("'spacingPixels': 5"));
    const auto moved = draw(surface, ballView("'spacingPixels': 5", fromFront, 1.0));
    ASSERT_EQ(still.dots.size(), moved.dots.size());
    double middle = 0.0, edge = 0.0;
    for (std::size_t i = 0; i < still.dots.size(); ++i) {
        const glm::dvec2 from(still.dots[i].x - 200.0, still.dots[i].y - 200.0);
        const glm::dvec2 way(moved.dots[i].x - still.dots[i].x, moved.dots[i].y - still.dots[i].y);
        EXPECT_NEAR(glm::dot(way, from) / glm::length(from), 0.0, 1e-3);  // across the radius
        const double sine = std::min(glm::length(from) / 150.0, 1.0);
        const double spacing = 5.0 / std::sqrt(std::sqrt(1.0 - sine * sine) + 1e-9);  // on the surface
        EXPECT_LE(glm::length(way), 0.5 * spacing * sine * sine + 1e-2);
        (sine < 0.3 ? middle : edge) = std::max(sine < 0.3 ? middle : edge, glm::length(way));
    }
    EXPECT_LT(middle, 0.25);
    EXPECT_GT(edge, 2.0);
}

TEST(SurfaceDots, ATransformedSurfaceIsTheSamePicture) {
    const auto surface = ballSurface(20000);
    const View view = ballView("'spacingPixels': 6");
    glm::dmat4 twice(2.0);
    twice[3] = {5.0, 1.0, 0.0, 1.0};
    View there = view;
    there.camera.eye = {5.0, 1.0, 8.0};
    there.camera.target = {5.0, 1.0, 0.0};
    *there.camera.orthographicHeight *= 2.0;
    const auto here = draw(surface, view), moved = draw(surface, there, twice);
    ASSERT_EQ(here.dots.size(), moved.dots.size());
    for (std::size_t i = 0; i < here.dots.size(); ++i) {
        EXPECT_NEAR(here.dots[i].x, moved.dots[i].x, 1e-3);
        EXPECT_NEAR(2.0 * here.dots[i].depth, moved.dots[i].depth, 1e-4);
    }
}

TEST(SurfaceDots, AreTheSameOnAnyNumberOfThreads) {
    const auto surface = ballSurface(20000);
    const View view =
        ballView("'spacingPixels': 4, 'value': 'depth', 'colorMap': 'viridis', 'leastDotPixels': 1");
    Dots one, four;
    tbb::task_arena(1).execute([&] { one = draw(surface, view).dots; });
    tbb::task_arena(4).execute([&] { four = draw(surface, view).dots; });
    EXPECT_EQ(one, four);
}

TEST(SurfaceDots, TheValueDrivesSizeAndColour) {
    const auto surface = ballSurface(20000);
    const View view = ballView(
        "'spacingPixels': 6, 'dotPixels': 4, 'leastDotPixels': 1, 'value': 'y', 'colorMap': 'viridis'");
    const auto map = ColorMap::find("viridis").value();
    for (const auto& dot : draw(surface, view).dots) {
        const double y = (200.0 - dot.y) / 150.0;
        EXPECT_NEAR(dot.radius, 0.5 + 1.5 * (0.5 + 0.5 * y), 1e-3);
        EXPECT_NEAR(dot.color.y, map(0.5 + 0.5 * y).y, 2e-2);
    }
}

/// A ball whose points the test shows and hides; all of its front is in view.
class SoftPointsTest : public testing::Test {
  protected:
    SoftPointsTest()
        : surface_(test::ballSurface(100)),
          view_(
              test::viewOf("{'width': 100, 'height': 100, 'camera': {'eye': [0, 0, 4], 'target': [0, 0, 0]},"
                           "'layers': [{'stipple': {}}]}")),
          layer_(surface_, *view_.layers[0].stipple(), view_, glm::dmat4(1.0)) {}

    const std::vector<ShownPoint>& step(std::vector<ShownPoint> wanted) {
        return soft_.step(surface_, layer_, std::move(wanted));
    }

    static constexpr glm::vec3 front{0.0F, 0.0F, 1.0F};
    StippleSurface surface_;
    View view_;
    SurfaceDots layer_;
    SoftPoints soft_;
};

TEST_F(SoftPointsTest, TheFirstPictureIsThereAtOnce) {
    EXPECT_EQ(step({{7, front}}).front().presence, 1.0F);
    EXPECT_TRUE(soft_.settled());
}

TEST_F(SoftPointsTest, PointsFadeInAndOut) {
    step({{7, front}});
    for (int i = 1; i <= SoftPoints::pictures; ++i) {
        const auto& shown = step({{9, front}});
        const float in = static_cast<float>(i) / SoftPoints::pictures;
        ASSERT_EQ(shown.size(), i < SoftPoints::pictures ? 2U : 1U);
        EXPECT_EQ(shown.back().point, 9U);
        EXPECT_FLOAT_EQ(shown.back().presence, in);
        if (shown.size() == 2) {
            EXPECT_FLOAT_EQ(shown.front().presence, 1.0F - in);
        }
        EXPECT_EQ(soft_.settled(), i == SoftPoints::pictures);
    }
}

TEST_F(SoftPointsTest, PointsGlide) {
    const glm::vec3 aside(0.1F, 0.0F, 0.99F);
    step({{7, front}});
    float last = 1.0F;
    for (int i = 0; i < 16 && !(i > 0 && soft_.settled()); ++i) {
        const auto& shown = step({{7, aside}});
        const float left = glm::distance(shown.front().position, aside);
        EXPECT_LT(left, 0.51F * last);
        EXPECT_EQ(shown.front().presence, 1.0F);
        last = std::max(left, 1e-6F);
    }
    EXPECT_TRUE(soft_.settled());
}

TEST_F(SoftPointsTest, WhatTheSurfaceHidesIsGoneAtOnce) {
    step({{7, front}, {9, -front}});
    EXPECT_EQ(step({{7, front}}).size(), 1U);
    EXPECT_TRUE(soft_.settled());
}

TEST_F(SoftPointsTest, SettlingEndsTheWay) {
    step({{7, front}});
    step({{9, front}});
    EXPECT_FALSE(soft_.settled());
    EXPECT_EQ(soft_.settle({{9, front}}).front().presence, 1.0F);
    EXPECT_TRUE(soft_.settled());
    EXPECT_EQ(step({{9, front}}).size(), 1U);
}

}  // namespace
}  // namespace mote::render
