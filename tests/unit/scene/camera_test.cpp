// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/camera.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <random>
#include <vector>

#include "protocol/base/json.h"

namespace mote {
namespace {

constexpr double rounding = 1e-12;  // a product of small matrices in double precision

proto::Camera plain() {
    proto::Camera message;
    for (const double x : {1.0, 2.0, 3.0}) message.add_eye(x);
    for (const double x : {0.0, 0.0, -1.0}) message.add_target(x);
    return message;
}

/// Where a point appears, in halves of the picture from its middle: within it from -1 to 1.
glm::dvec2 onScreen(const Camera& camera, const glm::dvec3& point, double aspect) {
    const auto eye = glm::dvec3(camera.worldToEye() * glm::dvec4(point, 1.0));
    const double half = camera.halfHeight() * (camera.perspective() ? -eye.z : 1.0);
    return {eye.x / (half * aspect), eye.y / half};
}

void expectNear(const glm::dvec3& actual, const glm::dvec3& expected) {
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(actual[i], expected[i], rounding) << i;
}

TEST(Camera, EyeSpaceIsRightHanded) {
    // From (0, 0, 4) along -z, eye space is the world moved.
    const auto toEye = Camera{}.worldToEye();
    expectNear(glm::dvec3(toEye * glm::dvec4(1.0, 2.0, 3.0, 1.0)), {1.0, 2.0, -1.0});
    // From +x, looking at the origin: the world's -z is to the right, y stays up.
    Camera side;
    side.eye = {5.0, 0.0, 0.0};
    expectNear(glm::dvec3(side.worldToEye() * glm::dvec4(0.0, 1.0, -2.0, 1.0)), {2.0, 1.0, -5.0});
}

TEST(Camera, HalfHeightIsOfTheVerticalAngle) {
    Camera camera;
    camera.fovYDegrees = 90.0;
    EXPECT_NEAR(camera.halfHeight(), 1.0, rounding);
    EXPECT_TRUE(camera.perspective());
    camera.orthographicHeight = 3.0;
    EXPECT_EQ(camera.halfHeight(), 1.5);
    EXPECT_FALSE(camera.perspective());
}

TEST(Camera, FittedHoldsTheBox) {
    const Bounds boxes[] = {
        plotBounds, {{-1e-4, -1e-4, 5.0}, {1e-4, 2e-4, 5.5}}, {{1e3, 0.0, 0.0}, {2e3, 1.0, 30.0}}};
    for (const auto& box : boxes) {
        for (const double aspect : {0.1, 0.5, 1.0, 16.0 / 9.0, 8.0}) {
            const Camera camera = fitCamera(box, aspect);
            double most = 0.0;
            for (const auto& corner : box.corners()) {
                const auto at = onScreen(camera, corner, aspect);
                EXPECT_LE(std::abs(at.x), 1.0) << aspect;
                EXPECT_LE(std::abs(at.y), 1.0) << aspect;
                most = std::max({most, std::abs(at.x), std::abs(at.y)});
            }
            // And fills it: a twentieth of the picture is left free on each side.
            EXPECT_NEAR(most, 1.0 - 2.0 * CameraFit::usualMargin, 1e-6) << aspect;
            // From a direction that shows three sides.
            const glm::dvec3 direction = camera.eye - camera.target;
            EXPECT_TRUE(direction.x > 0.0 && direction.y > 0.0 && direction.z > 0.0);
        }
    }
}

/// Over clouds of places, however turned: opposite sides are equally far, and what is told of in several
/// layers counts as in one.
TEST(Camera, FitsPlacesAndNotTheirBox) {
    std::mt19937_64 random(11);
    std::normal_distribution<double> number;
    const auto vector = [&] { return glm::dvec3(number(random), number(random), number(random)); };
    for (int i = 0; i < 50; ++i) {
        const Outlook outlook{vector(), vector()};
        const double aspect = std::exp(number(random));
        const glm::dmat4 transform{glm::dvec4(vector(), 0.0), glm::dvec4(vector(), 0.0),
                                   glm::dvec4(vector(), 0.0), glm::dvec4(10.0 * vector(), 1.0)};
        CameraFit fit(outlook, aspect, 0.1);
        fit.enter(transform);
        std::vector<glm::dvec3> places;
        for (int k = 0; k < 40; ++k) places.push_back(vector());
        for (const auto& place : places) fit.add(place);
        const Camera camera = fit.camera();
        glm::dvec2 least(1.0), most(-1.0);
        for (const auto& place : places) {
            const auto at = onScreen(camera, glm::dvec3(transform * glm::dvec4(place, 1.0)), aspect);
            least = glm::min(least, glm::dvec2(at));
            most = glm::max(most, glm::dvec2(at));
        }
        EXPECT_NEAR(std::max(most.x, most.y), 0.8, 1e-6);
        const int fuller = most.x > most.y ? 0 : 1;
        EXPECT_NEAR(least[fuller], -most[fuller], 1e-6);
        EXPECT_GT(glm::dot(camera.eye - camera.target, outlook.back), 0.0);
    }
}

/// Ellipsoids, flat and long and lopsided: what is seen lies in the middle of the picture, across and
/// upright.
TEST(Camera, FittedPlacesLieInTheMiddleOfThePicture) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> number(-1.0, 1.0);
    const auto vector = [&] { return glm::dvec3(number(random), number(random), number(random)); };
    double sum = 0.0;
    constexpr int clouds = 400;
    for (int i = 0; i < clouds; ++i) {
        const glm::dvec3 size = glm::pow(glm::dvec3(10.0), vector());
        const double aspect = std::exp(number(random));
        CameraFit fit({vector(), vector()}, aspect);
        std::vector<glm::dvec3> places;
        while (places.size() < 300)
            if (const glm::dvec3 at = vector(); glm::length(at) < 1.0)
                places.push_back(size * (places.size() % 3 == 0 ? at * glm::dvec3(1.0, 0.3, 1.0) : at));
        for (const auto& place : places) fit.add(place);
        const Camera camera = fit.camera();
        glm::dvec2 least(1.0), most(-1.0);
        for (const auto& place : places) {
            const auto at = onScreen(camera, place, aspect);
            ASSERT_GT(glm::dot(camera.eye - place, camera.eye - camera.target), 0.0);
            least = glm::min(least, at);
            most = glm::max(most, at);
        }
        const glm::dvec2 off = glm::abs(0.5 * (least + most));
        const double share = 1.0 - 2.0 * CameraFit::usualMargin;
        EXPECT_LE(std::max({most.x, most.y, -least.x, -least.y}), share + 1e-9);
        EXPECT_LT(std::max(off.x, off.y), 0.1);
        sum += std::max(off.x, off.y);
    }
    EXPECT_LT(sum / clouds, 0.01);
}

/// All sides touch the nearest end of a long line that is looked along: the eye does not lie on it.
TEST(Camera, FittedAlongALineKeepsAwayFromIt) {
    CameraFit fit({{0.0, 0.0, 1.0}, {0.0, 1.0, 0.0}}, 1.5);
    for (int i = 0; i <= 100; ++i) fit.add(glm::dvec3(0.0, 0.0, 10.0 * i));
    const Camera camera = fit.camera();
    EXPECT_NEAR(camera.eye.z, 1050.0, 1.0);
    EXPECT_LT(camera.target.z, 1000.0);
}

TEST(Camera, ABoxThatReachesNoFartherNeedsNotBeLookedInto) {
    CameraFit fit({}, 1.5);
    EXPECT_TRUE(fit.empty());
    fit.add(plotBounds);
    EXPECT_EQ(fit.inLayer(), plotBounds);
    EXPECT_FALSE(fit.reach({glm::dvec3(-0.9), glm::dvec3(0.9)}) > 0.0);
    EXPECT_TRUE(fit.reach({glm::dvec3(-0.9), glm::dvec3(0.9, 0.9, 1.1)}) > 0.0);
}

TEST(Camera, FittedToAPointIsACamera) {
    const Camera camera = fitCamera({glm::dvec3(2.0), glm::dvec3(2.0)}, 1.0);
    EXPECT_GT(glm::distance(camera.eye, camera.target), 0.0);
    EXPECT_TRUE(parseCamera(toProto(camera)).ok());
}

TEST(Camera, ParsesWhatItWrote) {
    for (const bool perspective : {true, false}) {
        Camera camera;
        camera.eye = {0.1, -2.5, 1e6};
        camera.up = {0.3, 1.0, 0.2};
        camera.fovYDegrees = 12.5;
        if (!perspective) camera.orthographicHeight = 1e-3;
        const auto again = parseCamera(toProto(camera));
        ASSERT_TRUE(again.ok()) << again.error().toString();
        EXPECT_EQ(*again, camera);
    }
}

TEST(Camera, DefaultsAreTheDocumentedOnes) {
    const auto camera = parseCamera(plain());
    ASSERT_TRUE(camera.ok());
    EXPECT_EQ(camera->up, glm::dvec3(0.0, 1.0, 0.0));
    EXPECT_EQ(camera->fovYDegrees, 35.0);
    EXPECT_TRUE(camera->perspective());
}

struct Bad {
    const char* what;
    std::function<void(proto::Camera&)> spoil;
    const char* where;
};

class BadCamera : public testing::TestWithParam<Bad> {};

TEST_P(BadCamera, IsAnErrorThatNamesItsField) {
    auto message = plain();
    ASSERT_TRUE(parseCamera(message).ok());
    GetParam().spoil(message);
    const auto result = parseCamera(message);
    ASSERT_FALSE(result.ok());
    EXPECT_EQ(result.error().code, ErrorCode::invalidArgument);
    EXPECT_EQ(result.error().where, GetParam().where);
    EXPECT_FALSE(result.error().message.empty());
}

void setVector(google::protobuf::RepeatedField<double>* field, const std::vector<double>& values) {
    field->Assign(values.begin(), values.end());
}

INSTANTIATE_TEST_SUITE_P(All, BadCamera,
                         testing::Values(Bad{"targetIsEye", [](auto& m) { *m.mutable_target() = m.eye(); },
                                             "target"},
                                         Bad{"targetAtEyeButRounding",
                                             [](auto& m) {
                                                 *m.mutable_target() = m.eye();
                                                 m.set_target(0, m.eye(0) + 1e-12);
                                             },
                                             "target"},
                                         Bad{"upZero",
                                             [](auto& m) {
                                                 setVector(m.mutable_up(), {0, 0, 0});
                                             },
                                             "up"},
                                         Bad{"upAlongSight",
                                             [](auto& m) {
                                                 setVector(m.mutable_up(), {-2, -4, -8});
                                             },
                                             "up"}),
                         [](const auto& bad) { return bad.param.what; });

TEST(Camera, AShortUpIsADirectionTheSame) {
    auto message = plain();
    setVector(message.mutable_up(), {0, 1e-9, 0});
    const auto camera = parseCamera(message);
    ASSERT_TRUE(camera.ok()) << camera.error().toString();
    EXPECT_TRUE(std::isfinite(camera->worldToEye()[0][0]));
}

}  // namespace
}  // namespace mote
