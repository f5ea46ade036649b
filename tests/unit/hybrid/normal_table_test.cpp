// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/hybrid/normal_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <random>

#include "storage/hybrid/hybrid_limits.h"

namespace mote::storage {
namespace {

glm::vec3 randomDirection(std::mt19937& random) {
    std::normal_distribution<float> normal;
    return glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
}

TEST(NormalTable, FindsTheNearestOfAllDirections) {
    const NormalTable table;
    std::mt19937 random(1);
    for (int i = 0; i < 100000; ++i) {
        const auto v = randomDirection(random);
        float greatest = -2.0F;
        for (int code = 1; code <= NormalTable::directions; ++code) {
            greatest = std::max(greatest, glm::dot(v, table.direction(static_cast<std::uint8_t>(code))));
        }
        // The table divides by another length than we do: products differ in their last bits.
        EXPECT_GE(glm::dot(v, table.direction(table.code(v * 3.7F))), greatest - 1e-6F);
    }
}

TEST(NormalTable, EveryDirectionIsItsOwnCode) {
    const NormalTable table;
    for (int code = 1; code <= NormalTable::directions; ++code) {
        const auto byte = static_cast<std::uint8_t>(code);
        EXPECT_NEAR(glm::length(table.direction(byte)), 1.0F, 1e-6F);
        EXPECT_EQ(table.code(table.direction(byte)), byte);
    }
    EXPECT_EQ(table.direction(NormalTable::none), glm::vec3(0.0F));
}

TEST(NormalTable, NoGradientHasNoDirection) {
    const NormalTable table;
    constexpr float nan = std::numeric_limits<float>::quiet_NaN();
    constexpr float infinite = std::numeric_limits<float>::infinity();
    EXPECT_EQ(table.code({0, 0, 0}), NormalTable::none);
    EXPECT_EQ(table.code({nan, 0, 1}), NormalTable::none);
    EXPECT_EQ(table.code({infinite, 0, 1}), NormalTable::none);
    EXPECT_NE(table.code({0, 0, -1e-30F}), NormalTable::none);
}

/// 255 caps that covered the sphere without overlap would have a radius of 7.2 degrees; in a hexagonal
/// pattern the furthest place from a point is 1.10 times that, 7.9. Fibonacci points keep below 1.45 times,
/// but at the poles (measured: 10.3 degrees).
TEST(NormalTable, DirectionsAreEvenlySpread) {
    const NormalTable table;
    std::mt19937 random(2);
    float worst = 1.0F;
    for (int i = 0; i < 100000; ++i) {
        const auto v = randomDirection(random);
        worst = std::min(worst, glm::dot(v, table.direction(table.code(v))));
    }
    EXPECT_GT(worst, std::cos(11.0F * 3.14159265F / 180.0F));
}

TEST(GridAxis, CentresOfCellsMeetOverTheSameBox) {
    EXPECT_EQ(placeIn(0, 512, 512), 0.0);
    EXPECT_EQ(placeIn(7, 512, 512), 7.0);
    EXPECT_EQ(placeIn(0, 128, 512), 1.5);
    EXPECT_EQ(placeIn(0, 512, 128), -0.375);
    EXPECT_EQ(placeIn(0, 1, 7), 3.0);
    EXPECT_DOUBLE_EQ(placeIn(6, 7, 1), 6.5 / 7 - 0.5);
}

TEST(GridAxis, AGridIsConstantBeyondItsEnds) {
    EXPECT_EQ(between(-0.4, 5).fraction, 0.0F);
    EXPECT_EQ(between(-0.4, 5).first, 0U);
    EXPECT_EQ(between(4.3, 5).first, 4U);
    EXPECT_EQ(between(4.3, 5).second, 4U);
    EXPECT_EQ(between(2.25, 5).second, 3U);
    EXPECT_EQ(between(2.25, 5).fraction, 0.25F);
    EXPECT_EQ(between(0.2, 1).second, 0U);
}

}  // namespace
}  // namespace mote::storage
