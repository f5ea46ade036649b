// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace mote {
namespace {

Curve curve(std::vector<Curve::Knot> knots) {
    return Curve::create(std::move(knots)).value();
}

TEST(Curve, IsLinearBetweenKnotsAndConstantBeyond) {
    const auto c = curve({{0.25, 0.5}, {0.75, 1.0}});
    EXPECT_EQ(c(0.0), 0.5);
    EXPECT_EQ(c(0.25), 0.5);
    EXPECT_DOUBLE_EQ(c(0.5), 0.75);
    EXPECT_EQ(c(0.75), 1.0);
    EXPECT_EQ(c(1.0), 1.0);
    EXPECT_EQ(c(-5.0), 0.5);
    EXPECT_EQ(c(5.0), 1.0);
}

TEST(Curve, OneKnotIsAConstant) {
    EXPECT_EQ(curve({{0.5, 0.3}})(0.1), 0.3);
    EXPECT_EQ(Curve::constant(0.3)(0.9), 0.3);
    EXPECT_EQ(Curve::constant(0.3).maximum(), 0.3);
}

TEST(Curve, AStepHoldsFromItsPlaceOn) {
    const auto c = curve({{0.0, 0.1}, {0.5, 0.1}, {0.5, 0.9}, {1.0, 0.9}});
    EXPECT_EQ(c(std::nextafter(0.5, 0.0)), 0.1);
    EXPECT_EQ(c(0.5), 0.9);
    // Of several knots at one place the last one holds; at the ends too.
    EXPECT_EQ(curve({{0.5, 0.1}, {0.5, 0.2}, {0.5, 0.3}})(0.5), 0.3);
    EXPECT_EQ(curve({{0.5, 0.1}, {0.5, 0.2}, {0.5, 0.3}})(0.4), 0.1);
    EXPECT_EQ(curve({{1.0, 0.1}, {1.0, 0.2}})(1.0), 0.2);
}

TEST(Curve, MaximumIsOfAllKnots) {
    EXPECT_EQ(curve({{0.0, 0.2}, {0.3, 0.9}, {1.0, 0.1}}).maximum(), 0.9);
}

TEST(Curve, StaysWithinItsKnots) {
    const auto c = curve({{0.1, 0.0}, {0.1 + 1e-16, 1.0}, {0.3, 0.2}, {0.9, 0.7}});
    for (int i = 0; i <= 1000; ++i) {
        EXPECT_GE(c(i / 1000.0), 0.0);
        EXPECT_LE(c(i / 1000.0), 1.0);
    }
}

struct BadKnots {
    const char* what;
    std::vector<Curve::Knot> knots;
    const char* where;
};

class BadCurve : public testing::TestWithParam<BadKnots> {};

TEST_P(BadCurve, IsAnErrorThatNamesItsKnot) {
    const auto result = Curve::create(GetParam().knots);
    ASSERT_FALSE(result.ok());
    EXPECT_EQ(result.error().code, ErrorCode::invalidArgument);
    EXPECT_EQ(result.error().where, GetParam().where);
}

constexpr double notANumber = std::numeric_limits<double>::quiet_NaN();

INSTANTIATE_TEST_SUITE_P(
    All, BadCurve,
    testing::Values(
        BadKnots{"none", {}, ""}, BadKnots{"tooMany", std::vector<Curve::Knot>(257, {0.5, 0.5}), ""},
        BadKnots{"descending", {{0.2, 0}, {0.6, 0}, {0.5, 0}}, "[2]"},
        BadKnots{"xNegative", {{-0.1, 0}}, "[0]"}, BadKnots{"xTooLarge", {{0.5, 0}, {1.5, 0}}, "[1]"},
        BadKnots{"yNegative", {{0.5, -0.01}}, "[0]"}, BadKnots{"yTooLarge", {{0.5, 1.01}}, "[0]"},
        BadKnots{"xNan", {{0.0, 0}, {notANumber, 0}}, "[1]"}, BadKnots{"yNan", {{0.0, notANumber}}, "[0]"},
        BadKnots{"yInfinite", {{0.0, std::numeric_limits<double>::infinity()}}, "[0]"}),
    [](const auto& bad) { return bad.param.what; });

TEST(Curve, AsManyKnotsAsAllowedAreAllowed) {
    EXPECT_TRUE(Curve::create(std::vector<Curve::Knot>(256, {0.5, 0.5})).ok());
}

}  // namespace
}  // namespace mote
