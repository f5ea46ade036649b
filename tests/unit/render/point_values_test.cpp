// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/point_values.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/random.h"

namespace mote::render {
namespace {

/// docs/PICTURE.md, "Colour by density".
double levelAt(const PointShade& shade, double t) {
    return 255.0 * std::clamp((t - shade.t.low) / (shade.t.high - shade.t.low), 0.0, 1.0);
}

TEST(DensityLevels, AreThoseOfT) {
    test::Random random(5);
    for (int i = 0; i < 2000; ++i) {
        const double low = random.unit(), span = 0.05 + random.unit();
        const PointShade shade{{low, low + span}, {0.75, 1.0}};
        const double least = random.magnitude(-3, 3);
        const LogDensity scale{least, least * random.magnitude(1, 9)};
        const DensityLevels levels(shade, scale);
        const double t = random.unit();
        const double density = scale.min * std::pow(scale.max / scale.min, t);
        const double level = levelAt(shade, t);
        EXPECT_NEAR(levels.of(static_cast<float>(density)), level, 0.5 + 1e-3);
        // As a preview of another scale tells it.
        const LogDensity told{scale.min * 2.0, scale.max};
        const auto line = LevelLine::ofPreview(shade, told, scale);
        const double said = 65535.0 * std::log(density / told.min) / std::log(told.max / told.min);
        EXPECT_NEAR(std::clamp(line.slope * said + line.shift, 0.0, 255.0), level, 1e-2);
    }
}

TEST(DensityLevels, OfAllDensities) {
    const PointShade shade{{0.25, 1.5}, {0.75, 1.0}};
    const DensityLevels levels(shade, {1.0, 1e6});
    EXPECT_EQ(levels.of(0.0F), 0);
    EXPECT_EQ(levels.of(1.0F), 0);
    EXPECT_EQ(levels.of(1e30F), 255);
    // All leaves of a plot of one density have t = 0.
    const DensityLevels one(shade, {3.0, 3.0});
    EXPECT_EQ(one.of(3.0F), 0);
    const DensityLevels middle({{-1.0, 1.0}, {0.75, 1.0}}, {3.0, 3.0});
    EXPECT_NEAR(middle.of(3.0F), 127.5, 0.5);
    EXPECT_NEAR(LevelLine::ofPreview({{-1.0, 1.0}, {0.75, 1.0}}, {3.0, 3.0}, {3.0, 3.0}).shift, 127.5, 1e-4);
}

TEST(DensityLevels, AreCodesOfAllTheRange) {
    EXPECT_EQ(DensityLevels::code(0), 0);
    EXPECT_EQ(DensityLevels::code(DensityLevels::last), greatestValue);
    EXPECT_NEAR(DensityLevels::code(100), greatestValue * 100.0 / 255.0, 0.5);
}

}  // namespace
}  // namespace mote::render
