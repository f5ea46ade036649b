// SPDX-License-Identifier: GPL-3.0-or-later
//
// What strokes of the brush make of an ink style.
#include "client/view/hand/brush.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "protocol/scene/ink_style.h"

namespace mote::client {
namespace {

/// From (0, 0, 4), the picture 720 high.
BrushStroke stroke() {
    BrushStroke stroke;
    stroke.height = 720.0;
    return stroke;
}

TEST(Brush, ARadiusIsAsLargeOnTheSurfaceAsOnTheScreen) {
    auto made = stroke();
    const double pixel = 2.0 * made.camera.halfHeight() * 4.0 / 720.0;
    EXPECT_NEAR(dabRadius(made, {0.5, 0.0, 0.0}), made.settings.radius * pixel, 1e-12);
    EXPECT_NEAR(dabRadius(made, {0.0, 0.0, 2.0}), made.settings.radius * pixel / 2.0, 1e-12) << "half as far";
    made.camera.orthographicHeight = 2.0;
    EXPECT_NEAR(dabRadius(made, {0.0, 0.0, 2.0}), made.settings.radius * 2.0 / 720.0, 1e-12);
    made.layerToWorld = glm::scale(glm::dmat4(1.0), glm::dvec3(10.0));
    EXPECT_NEAR(dabRadius(made, {0.0, 0.0, 2.0}), made.settings.radius * 0.2 / 720.0, 1e-12);
}

TEST(Brush, DabsGoOnInTheLastRegionThatIsAlike) {
    proto::InkStyle style;
    auto made = stroke();
    ASSERT_TRUE(paintDab(style, made, {0.0, 0.0, 0.0}).ok());
    ASSERT_TRUE(paintDab(style, made, {1.0, 0.0, 0.0}).ok());
    ASSERT_TRUE(paintDab(style, made, {1.0, 1e-3, 0.0}).ok());  // as good as there
    ASSERT_EQ(style.regions_size(), 1);
    EXPECT_EQ(style.regions(0).dabs_size(), 6);
    EXPECT_EQ(style.regions(0).fill(), "ink");
    made.settings.direction = 30.0;
    ASSERT_TRUE(paintDab(style, made, {2.0, 0.0, 0.0}).ok());
    made.settings.radius *= 2.0;
    ASSERT_TRUE(paintDab(style, made, {3.0, 0.0, 0.0}).ok());
    made.settings.whole = true;
    ASSERT_TRUE(paintDab(style, made, {4.0, 0.0, 0.0}).ok());
    ASSERT_EQ(style.regions_size(), 4);
    EXPECT_EQ(style.regions(1).direction_degrees(), 30.0);
    EXPECT_TRUE(parseInkStyle(style, glm::dvec3(1.0)).ok());
}

TEST(Brush, NoMoreRegionsThanMayBe) {
    proto::InkStyle style;
    auto made = stroke();
    for (int i = 0; i < mostInkRegions; ++i) {
        made.settings.direction = i;
        ASSERT_TRUE(paintDab(style, made, {0.1 * i, 0.0, 0.0}).ok());
    }
    made.settings.direction = -1.0;
    EXPECT_FALSE(paintDab(style, made, {0.0, 0.0, 0.0}).ok());
    EXPECT_EQ(style.regions_size(), mostInkRegions);
    EXPECT_TRUE(parseInkStyle(style, glm::dvec3(1.0)).ok());
}

TEST(Brush, WhatIsErasedIsGoneAndEmptyRegionsToo) {
    proto::InkStyle style;
    auto made = stroke();
    for (const double x : {0.0, 1.0, 2.0}) ASSERT_TRUE(paintDab(style, made, {x, 0.0, 0.0}).ok());
    made.settings.fill = "none";
    ASSERT_TRUE(paintDab(style, made, {1.0, 0.1, 0.0}).ok());
    eraseDabs(style, 0.3, {1.0, 0.0, 0.0});
    ASSERT_EQ(style.regions_size(), 1);
    EXPECT_EQ(std::vector<double>(style.regions(0).dabs().begin(), style.regions(0).dabs().end()),
              (std::vector<double>{0.0, 0.0, 0.0, 2.0, 0.0, 0.0}));
}

TEST(Brush, SizesStayWithinBounds) {
    Brush brush;
    brush.resize(1.0);
    EXPECT_GT(brush.settings.radius, BrushSettings().radius);
    brush.resize(-1e6);
    EXPECT_EQ(brush.settings.radius, BrushSettings::least);
    brush.resize(1e6);
    EXPECT_EQ(brush.settings.radius, BrushSettings::most);
}

}  // namespace
}  // namespace mote::client
