// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/stipple/soft_points.h"

#include <gtest/gtest.h>

#include "tests/support/ball_surface.h"
#include "tests/support/view_text.h"

namespace mote::render {
namespace {

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
