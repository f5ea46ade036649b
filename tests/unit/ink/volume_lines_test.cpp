// SPDX-License-Identifier: GPL-3.0-or-later
//
// Lines of scalar fields: the outline of a ball is its circle, and what lies in front of something else has
// an outline there.
#include "server/render/layers/ink/volume_lines.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/unit/ink/ink_views.h"
#include "tests/unit/ink/volume_scenes.h"

namespace mote::render {
namespace {

constexpr std::uint32_t volumeSide = 100;
constexpr double pixel = 0.02;  // units

VolumeModalities seen(const InkVolume& volume) {
    return modalitiesOf(volume, glm::dmat4(1.0), test::usualInk(),
                        test::planOf(test::ahead(volumeSide * pixel), volumeSide, volumeSide), {});
}

/// From a place of the layer, in units.
double distanceTo(const LinePoint& point, double right, double up) {
    return std::hypot(point.at.x * pixel - 1.0 - right, 1.0 - point.at.y * pixel - up);
}

double lengthOf(const InkLine& line) {
    double length = 0.0;
    for (std::size_t i = 1; i < line.points.size(); ++i)
        length += glm::distance(line.points[i - 1].at, line.points[i].at);
    return length;
}

TEST(VolumeLines, OfABallAreItsCircle) {
    constexpr double radius = 0.7;
    const auto lines = linesOf(seen(test::ball(64, radius)), {});
    ASSERT_EQ(lines.size(), 1U);
    const auto& points = lines[0].points;
    EXPECT_EQ(points.front().at, points.back().at) << "closed";
    // A ray grows opaque within a hundredth of the radius; points are left out that lie within an eighth of
    // a pixel of the line.
    for (const auto& point : points) {
        EXPECT_NEAR(distanceTo(point, 0.0, 0.0), radius, 0.35 * pixel);
        EXPECT_EQ(point.step, 1.0);
        EXPECT_NEAR(point.depth, 5.0, 0.2) << "beside the middle";
    }
    EXPECT_NEAR(lengthOf(lines[0]) * pixel, 2.0 * 3.14159265 * radius, 0.03 * radius);
    EXPECT_LT(points.size(), 200U) << "of half pixels it has 440";
}

TEST(VolumeLines, PartWhatLiesBehindFromWhatLiesInFront) {
    constexpr double radius = 0.4;
    const glm::dvec3 front(0.2, 0.0, 0.5), back(-0.2, 0.0, -0.5);
    const auto both =
        test::inkVolume(test::cubeShape(64), {{0.5, 0.0}, {0.51, 0.99}}, 0.01, [&](const glm::dvec3& at) {
            const double nearest = std::min(glm::distance(at, front), glm::distance(at, back));
            return std::clamp(0.5 + 0.5 * (radius - nearest), 0.0, 1.0);
        });
    const auto lines = linesOf(seen(both), {});
    double inside = 0.0;
    for (const auto& line : lines) {
        for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
            const auto& point = line.points[i];
            const double toFront = distanceTo(point, front.x, front.y),
                         toBack = distanceTo(point, back.x, back.y);
            // Where the outlines meet, in a corner, a smooth line leaves them.
            EXPECT_LT(std::min(std::abs(toFront - radius), std::abs(toBack - radius)), 1.5 * pixel);
            if (toBack > radius - 2.0 * pixel) continue;
            EXPECT_NEAR(toFront, radius, 0.7 * pixel) << "nothing of what is hidden";
            // One unit between their middles, and so between places as far from them on the way.
            EXPECT_GT(point.step, 0.2);
            EXPECT_LT(point.step, 0.7);
            inside += glm::distance(point.at, line.points[i + 1].at) * pixel;
        }
    }
    // Of the front ball's circle, what lies in the other's: twice an angle of acos(0.2 / 0.4).
    EXPECT_NEAR(inside, 2.0 * std::acos(0.5) * radius, 0.1);
}

TEST(VolumeLines, AreNotWhereMatterIsThin) {
    const auto haze =
        test::inkVolume(test::cubeShape(16), {{0.0, 0.2}}, 1.0, [](const auto&) { return 0.5; });
    EXPECT_TRUE(linesOf(seen(haze), {}).empty());
}

}  // namespace
}  // namespace mote::render
