// SPDX-License-Identifier: GPL-3.0-or-later
//
// What gamepads, 3D mice and held keys do to a camera.
#include "client/view/hand/steering.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>

#include "client/view/camera_control.h"

namespace mote::client {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr double near = 1e-9;

void expectAt(const glm::dvec3& place, const glm::dvec3& expected) {
    EXPECT_LT(glm::distance(place, expected), near) << place.x << ' ' << place.y << ' ' << place.z;
}

/// Looks along -z from (0, 0, 4).
Camera front() {
    return {};
}

TEST(Steering, SticksThatHardlyLeanAreAtRest) {
    Pad pad;
    EXPECT_TRUE(pushOf(pad, true).atRest()) << "the triggers rest at -1";
    pad.axes = {0.14F, -0.14F, 0.1F, 0.1F, -0.75F, -1.0F};
    EXPECT_TRUE(pushOf(pad, false).atRest());
    pad.axes[0] = 0.5F;
    const double share = (0.5 - deadZone) / (1.0 - deadZone);
    EXPECT_NEAR(pushOf(pad, true).go.x, share * share, near);
    pad.axes[0] = 1.0F;
    EXPECT_NEAR(pushOf(pad, true).go.x, 1.0, near);
}

TEST(Steering, APadFliesTheEyeOrCarriesWhatIsSeen) {
    Pad pad;
    pad.axes = {1.0F, -1.0F, -1.0F, 1.0F, 1.0F, -1.0F};  // sticks right and up, left and down; left trigger
    const auto flying = pushOf(pad, true), carrying = pushOf(pad, false);
    expectAt(flying.go, {1.0, -1.0, 1.0});
    expectAt(flying.turn, {-1.0, -1.0, 0.0});
    expectAt(carrying.go, {-1.0, -1.0, -1.0});
    expectAt(carrying.turn, {1.0, 1.0, 0.0});
}

TEST(Steering, APuckHoldsWhatIsSeenOrTheEye) {
    Puck puck;
    puck.axes = {1.0F, 1.0F, 1.0F, 0.0F, 0.0F, 0.0F};  // right, towards the hand, down
    expectAt(pushOf(puck, false).go, {1.0, -1.0, 1.0});
    expectAt(pushOf(puck, true).go, {1.0, -1.0, -1.0});
    puck.axes = {0.0F, 0.0F, 0.0F, 1.0F, 1.0F, 1.0F};
    expectAt(pushOf(puck, false).turn, {1.0, -1.0, 1.0});
    expectAt(pushOf(puck, true).turn, {1.0, 1.0, 1.0});
}

TEST(Steering, AllDevicesPushTogetherAndNoFartherThanOne) {
    Devices devices;
    EXPECT_TRUE(devices.atRest());
    devices.pads.resize(2);
    EXPECT_TRUE(devices.atRest());
    devices.pads[0].axes[0] = devices.pads[1].axes[0] = 1.0F;
    expectAt(devices.push(true).go, {1.0, 0.0, 0.0});
    devices.pads = {Pad{}};
    devices.pads[0].buttons[8] = true;
    EXPECT_FALSE(devices.atRest()) << "a button is held";
}

TEST(Steering, AButtonAsksOnceForItsCommand) {
    Pad before, now;
    now.buttons[0] = now.buttons[5] = now.buttons[2] = true;
    EXPECT_THAT(commandsOf(before, now), ElementsAre("Fit", "Next step"));
    EXPECT_THAT(commandsOf(now, now), IsEmpty());
    EXPECT_THAT(commandsOf(now, before), IsEmpty());
}

TEST(Steering, AJoystickIsA3DMouseByItsName) {
    EXPECT_TRUE(isPuck("3Dconnexion SpaceMouse Compact", 6));
    EXPECT_TRUE(isPuck("SpaceNavigator", 6));
    EXPECT_FALSE(isPuck("3Dconnexion SpaceMouse Compact", 5));
    EXPECT_FALSE(isPuck("Flight Stick with Throttle", 6));
}

TEST(Steering, AFlightMovesEyeAndTargetAlike) {
    const auto moved = flown(front(), {{0.0, 0.0, 1.0}, {}}, 0.5, 1.0);
    expectAt(moved.eye, {0.0, 0.0, 3.5});
    expectAt(moved.target, {0.0, 0.0, -0.5});
    const auto aside = flown(front(), {{1.0, -1.0, 0.0}, {}}, 2.0, 1.0);
    expectAt(aside.eye, {2.0, -2.0, 4.0});
    expectAt(aside.target, {2.0, -2.0, 0.0});
}

TEST(Steering, AFlightTurnsAboutTheEye) {
    const double angle = 0.3;
    const auto right = flown(front(), {{}, {1.0, 0.0, 0.0}}, 1.0, angle);
    expectAt(right.eye, front().eye);
    expectAt(right.target - right.eye, {4.0 * std::sin(angle), 0.0, -4.0 * std::cos(angle)});
    const auto up = flown(front(), {{}, {0.0, 1.0, 0.0}}, 1.0, angle);
    expectAt(up.target - up.eye, {0.0, 4.0 * std::sin(angle), -4.0 * std::cos(angle)});
    const auto steep = flown(front(), {{}, {0.0, 1.0, 0.0}}, 1.0, 3.0);
    EXPECT_GT(glm::length(glm::cross(steep.target - steep.eye, steep.up)), 0.01) << "not over the pole";
}

TEST(Steering, WhatIsSeenGoesAlongWithTheDragThatLooksAround) {
    const glm::dvec2 drag(0.01, -0.02);
    const auto turned = lookedAround(front(), drag);
    expectAt(turned.eye, front().eye);
    const auto seen = seenAt(turned, 1.0, front().target);
    ASSERT_TRUE(seen);
    // The tangent of so small an angle is larger by less than 1e-6.
    EXPECT_NEAR(seen->x - 0.5, drag.x, 1e-5);
    EXPECT_NEAR(seen->y - 0.5, drag.y, 1e-5);
}

TEST(Steering, WhatIsCarriedTurnsAboutTheTargetAndComesNearer) {
    const auto near = carried(front(), {{0.0, 0.0, 1.0}, {}}, 0.1);
    expectAt(near.target, front().target);
    EXPECT_NEAR(near.eye.z, 4.0 * 0.9, 1e-9);  // ten tenths of the way a second
    const auto turned = carried(front(), {{}, {1.0, 0.0, 0.0}}, 1.0);
    expectAt(turned.target, front().target);
    expectAt(turned.eye, {-4.0, 0.0, 0.0});  // half a half turn
    const auto aside = carried(front(), {{1.0, 0.0, 0.0}, {}}, 1.0);
    EXPECT_LT(aside.eye.x, 0.0) << "what is seen goes to the right";
}

TEST(Steering, TheWheelChangesTheSpeedWithinBounds) {
    FlightSpeed speed;
    const double before = speed.share();
    speed.change(1.0);
    EXPECT_GT(speed.share(), before);
    speed.change(-1.0);
    EXPECT_NEAR(speed.share(), before, 1e-12);
    speed.change(-1e6);
    EXPECT_GT(speed.share(), 0.0);
    speed.change(1e6);
    EXPECT_LE(speed.share(), 20.0);
}

}  // namespace
}  // namespace mote::client
