// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/log_density.h"

#include <gtest/gtest.h>

#include <limits>

namespace mote {
namespace {

TEST(LogDensity, OfALeafIsTheShareOfTheLogarithm) {
    const LogDensity scale{1.0, 1e4};
    EXPECT_EQ(scale.ofLeaf(1.0), 0.0);
    EXPECT_NEAR(scale.ofLeaf(10.0), 0.25, 1e-15);
    EXPECT_EQ(scale.ofLeaf(1e4), 1.0);
    EXPECT_EQ(scale.ofLeaf(0.5), 0.0);
    EXPECT_EQ(scale.ofLeaf(1e5), 1.0);
}

TEST(LogDensity, OfACellGoesBelowZero) {
    const LogDensity scale{1.0, 1e8};
    EXPECT_EQ(scale.ofCell(0.0), -LogDensity::fade);
    EXPECT_EQ(scale.ofCell(-1.0), -LogDensity::fade);
    EXPECT_EQ(scale.ofCell(1e-30), -LogDensity::fade);
    EXPECT_NEAR(scale.ofCell(0.1), -0.125, 1e-15);
    EXPECT_NEAR(scale.ofCell(std::sqrt(0.1)), -0.0625, 1e-15);
    EXPECT_EQ(scale.ofCell(1e9), 1.0);
    EXPECT_EQ(scale.ofCell(std::numeric_limits<double>::quiet_NaN()), -LogDensity::fade);
}

TEST(LogDensity, OneDensityIsEnough) {
    const LogDensity scale{4.0, 4.0};
    EXPECT_EQ(scale.ofLeaf(4.0), 0.0);
    EXPECT_EQ(scale.ofCell(4.0), 0.0);
    EXPECT_EQ(scale.ofCell(9.0), 0.0);
    EXPECT_EQ(scale.ofCell(0.0), -LogDensity::fade);
    EXPECT_NEAR(scale.ofCell(2.0), -0.5 * LogDensity::fade, 1e-15);
}

}  // namespace
}  // namespace mote
