// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/bounds.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>
#include <set>

namespace mote {
namespace {

TEST(Bounds, CentreSizeAndCorners) {
    const Bounds box{{-1.0, 2.0, 3.0}, {3.0, 4.0, 9.0}};
    EXPECT_EQ(box.center(), glm::dvec3(1.0, 3.0, 6.0));
    EXPECT_EQ(box.size(), glm::dvec3(4.0, 2.0, 6.0));
    std::set<std::array<double, 3>> corners;
    for (const auto& corner : box.corners()) {
        corners.insert({corner.x, corner.y, corner.z});
        for (int axis = 0; axis < 3; ++axis) {
            EXPECT_TRUE(corner[axis] == box.min[axis] || corner[axis] == box.max[axis]);
        }
    }
    EXPECT_EQ(corners.size(), 8U);
}

TEST(Bounds, UnitedHoldsBoth) {
    const Bounds one{{0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}};
    const Bounds other{{-2.0, 0.5, 0.5}, {0.5, 3.0, 0.6}};
    EXPECT_EQ(one.united(other), (Bounds{{-2.0, 0.0, 0.0}, {1.0, 3.0, 1.0}}));
    EXPECT_EQ(one.united(other), other.united(one));
    EXPECT_EQ(one.united(one), one);
}

TEST(Bounds, TransformedIsTheLeastBoxAroundTheCorners) {
    // A quarter turn about z takes x to y; then a move.
    const glm::dmat4 turn(0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 10, 20, 30, 1);
    const Bounds box{{-1.0, -2.0, -3.0}, {4.0, 5.0, 6.0}};
    EXPECT_EQ(box.transformed(turn), (Bounds{{5.0, 19.0, 27.0}, {12.0, 24.0, 36.0}}));
    EXPECT_EQ(box.transformed(glm::dmat4(1.0)), box);
    // An eighth of a turn widens a unit square by the square root of two.
    const auto eighth = glm::rotate(glm::dmat4(1.0), glm::radians(45.0), glm::dvec3(0.0, 0.0, 1.0));
    EXPECT_NEAR(plotBounds.transformed(eighth).max.x, std::sqrt(2.0), 1e-15);
    // A mirror exchanges the sides.
    EXPECT_EQ(box.transformed(glm::scale(glm::dmat4(1.0), glm::dvec3(-1.0))),
              (Bounds{{-4.0, -5.0, -6.0}, {1.0, 2.0, 3.0}}));
}

}  // namespace
}  // namespace mote
