// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/camera_control.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace mote::client {
namespace {

constexpr double tolerance = 1e-9;  // double rounding of a few rotations, with room

/// Where a world point appears, in heights of the picture from its middle, y down as the mouse.
glm::dvec2 onScreen(const Camera& camera, const glm::dvec3& point) {
    const glm::dvec4 eye = camera.worldToEye() * glm::dvec4(point, 1.0);
    const double depth = camera.perspective() ? -eye.z : 1.0;
    return glm::dvec2(eye.x, -eye.y) / (2.0 * camera.halfHeight() * depth);
}

TEST(CameraControl, OrbitKeepsDistanceAndTarget) {
    const Camera before;
    const Camera after = orbit(before, {0.3, -0.2});
    EXPECT_NEAR(glm::distance(after.eye, after.target), glm::distance(before.eye, before.target), tolerance);
    EXPECT_EQ(after.target, before.target);
    EXPECT_GT(glm::distance(after.eye, before.eye), 0.5);
}

TEST(CameraControl, OrbitFollowsTheMouse) {
    // A point in front of the target moves the way the mouse does.
    const Camera before;
    const glm::dvec3 front(0.0, 0.0, 0.5);
    EXPECT_GT(onScreen(orbit(before, {0.1, 0.0}), front).x, onScreen(before, front).x);
    EXPECT_GT(onScreen(orbit(before, {0.0, 0.1}), front).y, onScreen(before, front).y);
}

TEST(CameraControl, OrbitStopsAtThePoles) {
    Camera camera;
    for (int i = 0; i < 50; ++i) camera = orbit(camera, {0.0, 0.2});
    EXPECT_TRUE(parseCamera(toProto(camera)).ok());
    EXPECT_GT(camera.eye.y, 3.9);
}

TEST(CameraControl, PanKeepsTheTargetPlaneUnderTheMouse) {
    const glm::dvec2 drag(0.17, -0.08);
    for (const Camera& before : {Camera{}, toggleProjection(Camera{})}) {
        const glm::dvec2 moved = onScreen(pan(before, drag), before.target) - onScreen(before, before.target);
        EXPECT_NEAR(moved.x, drag.x, tolerance);
        EXPECT_NEAR(moved.y, drag.y, tolerance);
    }
}

TEST(CameraControl, DollyMovesTheEyeAndZoomDoesNot) {
    const Camera before;
    EXPECT_LT(glm::distance(dolly(before, 1.0).eye, before.target), glm::distance(before.eye, before.target));
    EXPECT_EQ(zoom(before, 1.0).eye, before.eye);
    EXPECT_LT(zoom(before, 1.0).fovYDegrees, before.fovYDegrees);
}

TEST(CameraControl, TheEyeGoesToAnySideOfTheTarget) {
    const Camera before = pan(orbit(Camera{}, {0.3, 0.1}), {0.1, 0.2});
    const auto front = lookFrom(before, 1, false);
    EXPECT_NEAR(glm::distance(front.eye, before.target), glm::distance(before.eye, before.target), tolerance);
    EXPECT_LT(front.eye.y, before.target.y);
    EXPECT_EQ(front.up, glm::dvec3(0.0, 0.0, 1.0));
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_TRUE(parseCamera(toProto(lookFrom(before, axis, true))).ok());
        EXPECT_TRUE(parseCamera(toProto(lookFrom(before, axis, false))).ok());
    }
}

TEST(CameraControl, NoGestureLeavesTheValidCameras) {
    for (Camera camera : {Camera{}, toggleProjection(Camera{})}) {
        for (const double steps : {1e6, -1e6, 1e6}) {
            camera = zoom(dolly(camera, steps), steps);
            EXPECT_TRUE(parseCamera(toProto(camera)).ok()) << steps;
        }
    }
}

TEST(CameraControl, TogglingProjectionTwiceIsNothing) {
    const Camera before = orbit(Camera{}, {0.2, 0.1});
    const Camera after = toggleProjection(toggleProjection(before));
    EXPECT_NEAR(glm::distance(after.eye, before.eye), 0.0, tolerance);
    EXPECT_TRUE(after.perspective());
}

}  // namespace
}  // namespace mote::client
