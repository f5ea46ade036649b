// SPDX-License-Identifier: GPL-3.0-or-later
//
// The way of the camera through keyframes.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <vector>

#include "protocol/scene/film/path_length.h"
#include "protocol/scene/view.h"
#include "tests/unit/scene/film_scripts.h"

namespace mote::test {
namespace {

/// The same picture, whatever the length of `up`.
void expectSameCamera(const Camera& a, const Camera& b, double tolerance) {
    EXPECT_LT(glm::distance(a.eye, b.eye), tolerance);
    EXPECT_LT(glm::distance(a.target, b.target), tolerance);
    const auto one = a.worldToEye(), other = b.worldToEye();
    for (int i = 0; i < 4; ++i) EXPECT_LT(glm::distance(one[i], other[i]), tolerance);
    EXPECT_NEAR(a.halfHeight(), b.halfHeight(), tolerance);
}

TEST(FilmCamera, KeyframesAreMetOnTheWay) {
    Random random(31);
    for (int i = 0; i < 100; ++i) {
        const auto script = anyCameraWay(random, 5);
        std::vector<CameraPath::Stop> stops;
        for (const auto& keyframe : script.keyframes())
            stops.push_back({keyframe.seconds(), parseCamera(keyframe.view().camera()).value()});
        const CameraPath path(stops);
        for (std::size_t way = 0; way < path.ways(); ++way) {
            expectSameCamera(path.at(way, 0.0), stops[way].camera, 1e-9);
            expectSameCamera(path.at(way, 1.0), stops[way + 1].camera, 1e-9);
        }
    }
}

struct Motion {
    glm::dvec3 eye, target, up;
};

/// What changes a second, from `at` towards a time very near.
Motion motion(const Film& film, double at, double step) {
    const auto a = cameraAt(film, at), b = cameraAt(film, at + step), c = cameraAt(film, at + 2.0 * step);
    const auto rate = [&](const glm::dvec3& x, const glm::dvec3& y, const glm::dvec3& z) {
        return (-1.5 * x + 2.0 * y - 0.5 * z) / step;
    };
    return {rate(a.eye, b.eye, c.eye), rate(a.target, b.target, c.target), rate(a.up, b.up, c.up)};
}

TEST(FilmCamera, SpeedDoesNotJumpAtKeyframes) {
    Random random(32);
    for (int i = 0; i < 150; ++i) {
        auto script = anyCameraWay(random, 5);
        for (auto& keyframe : *script.mutable_keyframes()) {
            keyframe.set_easing(random.oneOf({"", "linear", "linear", "smooth"}));
            // As they come out of the path: of unit length, at a right angle to the line of sight.
            auto camera = parseCamera(keyframe.view().camera()).value();
            const glm::dvec3 back = glm::normalize(camera.eye - camera.target);
            camera.up = glm::normalize(camera.up - glm::dot(camera.up, back) * back);
            *keyframe.mutable_view()->mutable_camera() = toProto(camera);
        }
        const Film film = filmOf(script);
        for (int k = 1; k + 1 < script.keyframes_size(); ++k) {
            const double at = script.keyframes(k).seconds(), step = 2e-5;
            const Motion before = motion(film, at, -step), after = motion(film, at, step);
            const double scale = 1.0 + glm::length(after.eye) + glm::length(before.eye);
            EXPECT_LT(glm::distance(before.eye, after.eye), 2e-3 * scale) << i << " " << k;
            EXPECT_LT(glm::distance(before.target, after.target), 2e-3 * scale) << i << " " << k;
            EXPECT_LT(glm::distance(before.up, after.up), 2e-3 * scale) << i << " " << k;
        }
    }
}

/// A camera on a tilted circle.
Camera onCircle(double radians) {
    const glm::dvec3 axis = glm::normalize(glm::dvec3(0.3, 1.0, -0.2));
    const glm::dmat4 turn = glm::rotate(glm::dmat4(1.0), radians, axis);
    Camera camera;
    camera.target = {1.0, 2.0, 3.0};
    camera.eye = camera.target + glm::dvec3(turn * glm::dvec4(2.0, 1.0, 3.0, 0.0));
    camera.up = glm::dvec3(turn * glm::dvec4(axis, 0.0));
    return camera;
}

proto::Script orbit(int keyframes, double radiansEach) {
    proto::Script script;
    for (int i = 0; i < keyframes; ++i) {
        auto& keyframe = *script.add_keyframes();
        keyframe.set_seconds(2.0 * i);
        keyframe.mutable_view()->set_width(64);
        keyframe.mutable_view()->set_height(48);
        *keyframe.mutable_view()->mutable_camera() = toProto(onCircle(radiansEach * i));
    }
    return script;
}

TEST(FilmCamera, AnOrbitIsACircleWithEvenAngles) {
    for (const double degrees : {10.0, 45.0, 90.0, 120.0, 170.0}) {
        for (const int keyframes : {2, 3, 7}) {
            const double each = degrees * glm::pi<double>() / 180.0;
            const Film film = filmOf(orbit(keyframes, each));
            for (std::size_t i = 0; i < film.frameCount(); ++i) {
                const double seconds = film.secondsOf(i);
                expectSameCamera(cameraAt(film, seconds), onCircle(each * seconds / 2.0), 1e-9);
            }
        }
    }
}

TEST(FilmCamera, TurnsTheShorterWay) {
    Random random(33);
    for (int i = 0; i < 100; ++i) {
        const double degrees = random.between(-175.0, 175.0);
        const Film film = filmOf(orbit(2, degrees * glm::pi<double>() / 180.0));
        const auto first = cameraAt(film, 0.0), middle = cameraAt(film, 1.0);
        const double cosine = glm::dot(glm::normalize(first.up), glm::normalize(middle.up));
        EXPECT_GT(cosine, -1e-9) << "half of the way is at most a quarter turn";
        expectSameCamera(middle, onCircle(degrees * glm::pi<double>() / 360.0), 1e-9);
    }
}

TEST(FilmCamera, StaysWhereTwoKeyframesAreTheSame) {
    Random random(34);
    for (int i = 0; i < 50; ++i) {
        auto script = anyCameraWay(random, 4);
        *script.mutable_keyframes(2)->mutable_view() = script.keyframes(1).view();
        const Film film = filmOf(script);
        const double from = script.keyframes(1).seconds(), to = script.keyframes(2).seconds();
        for (int k = 0; k <= 10; ++k)
            expectSameCamera(cameraAt(film, from + 0.1 * k * (to - from)), cameraAt(film, from), 1e-9);
    }
}

TEST(FilmCamera, FromPerspectiveToParallelThroughALongLens) {
    Random random(35);
    for (int i = 0; i < 60; ++i) {
        auto script = anyCameraWay(random, 3);
        auto& parallel = *script.mutable_keyframes(1)->mutable_view()->mutable_camera();
        const auto middle = parseCamera(parallel).value();
        const double height = 2.0 * glm::distance(middle.eye, middle.target) * middle.halfHeight();
        parallel.set_orthographic_height(height);
        const Film film = filmOf(script);
        const double at = script.keyframes(1).seconds();
        EXPECT_TRUE(cameraAt(film, at).orthographicHeight.has_value());
        for (const double near : {at - 1e-4, at + 1e-4}) {
            const auto camera = cameraAt(film, near);
            EXPECT_TRUE(camera.perspective());
            EXPECT_LT(camera.fovYDegrees, 0.11);
            const double spans = 2.0 * glm::distance(camera.eye, camera.target) * camera.halfHeight();
            EXPECT_NEAR(spans, height, 2e-3 * height);
            EXPECT_LT(glm::distance(camera.target, middle.target), 1e-2);
        }
        for (std::size_t k = 0; k < film.frameCount(); ++k) EXPECT_TRUE(parseView(film.frame(k)).ok());
    }
}

TEST(FilmCamera, ParallelOnesStayParallel) {
    Random random(36);
    auto script = anyCameraWay(random, 4);
    for (auto& keyframe : *script.mutable_keyframes())
        keyframe.mutable_view()->mutable_camera()->set_orthographic_height(random.magnitude(-2, 3));
    const Film film = filmOf(script);
    for (std::size_t i = 0; i < film.frameCount(); ++i)
        EXPECT_TRUE(cameraAt(film, film.secondsOf(i)).orthographicHeight.has_value());
}

/// Any that a view may have, at the ends of its ranges too.
proto::Camera extremeCamera(Random& random) {
    while (true) {
        Camera camera;
        camera.target = random.magnitude(-30, 39) * random.direction();
        camera.eye = camera.target + random.magnitude(-40, 39) * random.direction();
        camera.up = random.magnitude(-20, 20) * random.direction();
        camera.fovYDegrees = random.oneOf({0.1, 1.0, 35.0, 179.0});
        if (random.chance(0.4)) camera.orthographicHeight = random.magnitude(-29, 39);
        if (parseCamera(toProto(camera)).ok()) return toProto(camera);
    }
}

TEST(FilmCamera, IsLegalEverywhere) {
    Random random(40);
    for (int i = 0; i < 300; ++i) {
        auto script = anyCameraWay(random, 4);
        for (auto& keyframe : *script.mutable_keyframes()) {
            *keyframe.mutable_view()->mutable_camera() = extremeCamera(random);
            keyframe.set_easing(random.oneOf({"", "smooth"}));
        }
        const Film film = filmOf(script);
        for (std::size_t k = 0; k < film.frameCount(); ++k) {
            const auto view = parseView(film.frame(k));
            ASSERT_TRUE(view.ok()) << i << " " << k << " " << view.error().toString()
                                   << film.frame(k).DebugString();
        }
    }
}

double movedBetween(const Camera& a, const Camera& b) {
    return std::max(glm::distance(a.eye, b.eye), glm::distance(a.target, b.target));
}

/// How far the camera goes from each frame to the next: in many parts on its way, in one straight across its
/// bends.
std::vector<double> waysOfFrames(const Film& film, int parts) {
    std::vector<double> ways;
    const double spacing = film.secondsOf(1) - film.secondsOf(0);
    for (std::size_t i = 0; i + 1 < film.frameCount(); ++i) {
        double way = 0.0;
        auto last = cameraAt(film, film.secondsOf(i));
        for (int k = 1; k <= parts; ++k) {
            const auto next = cameraAt(film, film.secondsOf(i) + spacing * k / parts);
            way += movedBetween(last, next);
            last = next;
        }
        ways.push_back(way);
    }
    return ways;
}

double largestChange(const std::vector<double>& ways) {
    double sum = 0.0, most = 0.0;
    for (const double way : ways) sum += way;
    for (std::size_t i = 0; i + 1 < ways.size(); ++i) most = std::max(most, std::abs(ways[i + 1] - ways[i]));
    return most / (sum / static_cast<double>(ways.size()));
}

TEST(FilmCamera, ConstantSpeed) {
    Random random(37);
    double worst = 0.0;
    for (int i = 0; i < 25; ++i) {
        auto script = anyCameraWay(random, 2 + static_cast<int>(random.below(6)));
        script.set_constant_speed(true);
        script.set_fps(random.oneOf({24.0, 30.0, 60.0}));
        worst = std::max(worst, largestChange(waysOfFrames(filmOf(script), 32)));
    }
    RecordProperty("largest change of speed, millionths of the mean", static_cast<int>(1e6 * worst));
    EXPECT_LT(worst, 0.005);
}

TEST(FilmCamera, ConstantSpeedFromFrameToFrame) {
    Random random(39);
    double worst = 0.0;
    for (int i = 0; i < 50; ++i) {
        auto script = anyJourney(random, 3 + static_cast<int>(random.below(6)));
        EXPECT_GT(largestChange(waysOfFrames(filmOf(script), 1)), 0.003) << "by time it is not";
        script.set_constant_speed(true);
        worst = std::max(worst, largestChange(waysOfFrames(filmOf(script), 1)));
    }
    RecordProperty("largest change of speed, millionths of the mean", static_cast<int>(1e6 * worst));
    EXPECT_LT(worst, 0.02);
}

TEST(FilmCamera, OfConstantSpeedGoesTheSameWay) {
    Random random(38);
    auto script = anyCameraWay(random, 5);
    const Film byTime = filmOf(script);
    script.set_constant_speed(true);
    const Film even = filmOf(script);
    expectSameCamera(cameraAt(even, 0.0), cameraAt(byTime, 0.0), 1e-12);
    expectSameCamera(cameraAt(even, even.seconds()), cameraAt(byTime, byTime.seconds()), 1e-12);
    for (int i = 0; i < 50; ++i) {
        const auto camera = cameraAt(even, even.seconds() * i / 50.0);
        double nearest = 1e9;
        for (int k = 0; k <= 5000; ++k)
            nearest =
                std::min(nearest, movedBetween(camera, cameraAt(byTime, byTime.seconds() * k / 5000.0)));
        EXPECT_LT(nearest, 0.02);
    }
}

TEST(FilmCamera, WithoutAWayConstantSpeedGoesByTime) {
    const auto script = scriptOf(
        "{'constantSpeed': true, 'keyframes': ["
        "{'seconds': 0, 'view': {'width': 8, 'height': 8, 'background': [0, 0, 0]}},"
        "{'seconds': 2, 'view': {'width': 8, 'height': 8, 'background': [1, 1, 1]}}]}");
    const auto view = parseView(filmOf(script).at(0.5)).value();
    EXPECT_NEAR(view.background.x, 0.25, 1e-12);
}

}  // namespace
}  // namespace mote::test
