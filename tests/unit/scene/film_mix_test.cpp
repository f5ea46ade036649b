// SPDX-License-Identifier: GPL-3.0-or-later
//
// What lies between two numbers, directions, curves and transforms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>

#include "protocol/scene/film/mix_transform.h"
#include "protocol/scene/film/steps_between.h"
#include "protocol/scene/mix.h"
#include "tests/unit/scene/film_scripts.h"
#include "tests/views/random_curves.h"

namespace mote::test {
namespace {

TEST(Mix, NumbersAreExactAtTheEndsAndKeepTheirOrder) {
    Random random(41);
    for (int i = 0; i < 5000; ++i) {
        const double a = random.between(-1.0, 1.0) / 3.0, b = random.between(-1.0, 1.0) / 7.0;
        const double share = random.unit() / 3.0;
        EXPECT_EQ(mix(a, b, 0.0), a);
        EXPECT_EQ(mix(a, b, 1.0), b);
        EXPECT_EQ(mix(a, a, share), a);
        const double low = std::min(a, b), high = std::max(a, b);
        EXPECT_LE(mix(low, a, share), mix(high, a, share));
        EXPECT_GE(mix(a, b, share), low);
        EXPECT_LE(mix(a, b, share), high);
    }
}

TEST(Mix, DirectionsTurnEvenlyTheShortWay) {
    Random random(42);
    for (int i = 0; i < 500; ++i) {
        const glm::dvec3 a = random.direction(), b = i % 10 == 0 ? -a : random.direction();
        const double angle = std::acos(std::clamp(glm::dot(a, b), -1.0, 1.0));
        EXPECT_EQ(mixDirections(a, b, 0.0), a);
        EXPECT_EQ(mixDirections(a, b, 1.0), b);
        EXPECT_EQ(mixDirections(a, a, 0.3), a);
        for (const double share : {0.25, 0.5, 0.875}) {
            const glm::dvec3 between = mixDirections(a, b, share);
            EXPECT_NEAR(glm::length(between), 1.0, 1e-14);
            EXPECT_NEAR(std::acos(std::clamp(glm::dot(a, between), -1.0, 1.0)), share * angle, 1e-7);
        }
    }
}

ColoredCurve anyCurve(Random& random, bool colored) {
    ColoredCurve curve{Curve::create(anyKnots(random, {-2.0, 3.0}), -2.0, 3.0).value()};
    for (std::size_t i = 0; colored && i < curve.curve.knots().size(); ++i)
        curve.colors.emplace_back(random.unit(), random.unit(), random.unit());
    return curve;
}

TEST(MixCurves, OfUnequallyManyKnotsHaveTheValuesBetween) {
    Random random(43);
    int seen = 0;
    for (int i = 0; i < 2000; ++i) {
        const auto a = anyCurve(random, false), b = anyCurve(random, false);
        if (a.curve.knots().size() == b.curve.knots().size() || !canMix(a, b)) continue;
        ++seen;
        const double share = random.unit();
        const auto mixed = mixCurves(a, b, share);
        std::vector<double> places;
        for (int k = 0; k < 20; ++k) places.push_back(random.between(-3.0, 4.0));
        for (const auto& knot : a.curve.knots()) places.push_back(knot.x);  // where steps are, too
        for (const auto& knot : b.curve.knots()) places.push_back(knot.x);
        for (const double x : places)
            ASSERT_NEAR(mixed.curve(x), (1.0 - share) * a.curve(x) + share * b.curve(x), 1e-9) << x;
    }
    EXPECT_GT(seen, 500);
}

TEST(MixCurves, OfAsManyKnotsGoKnotByKnot) {
    const ColoredCurve a{Curve::create({{0.0, 0.0}, {0.2, 1.0}}).value(), {glm::dvec3(0.0), glm::dvec3(1.0)}};
    const ColoredCurve b{Curve::create({{0.4, 0.0}, {1.0, 0.5}}).value(), {glm::dvec3(1.0), glm::dvec3(0.0)}};
    const auto half = mixCurves(a, b, 0.5);
    EXPECT_EQ(half.curve, Curve::create({{0.2, 0.0}, {0.6, 0.75}}).value());
    EXPECT_EQ(half.colors[0], glm::dvec3(0.5));
    EXPECT_EQ(mixCurves(a, b, 0.0), a);
    EXPECT_EQ(mixCurves(a, b, 1.0), b);
    EXPECT_FALSE(canMix(a, {b.curve, {}}));
}

TEST(MixCurves, ColoursGoByTheirValues) {
    const ColoredCurve a{Curve::create({{0.0, 0.0}, {1.0, 1.0}}).value(), {glm::dvec3(0.0), glm::dvec3(1.0)}};
    const ColoredCurve b{Curve::constant(0.5), {glm::dvec3(0.5)}};
    const auto half = mixCurves(a, b, 0.5);
    ASSERT_EQ(half.colors.size(), half.curve.knots().size());
    EXPECT_NEAR(half.colors.front().x, 0.25, 1e-12);
    EXPECT_NEAR(half.colors.back().x, 0.75, 1e-12);
}

TEST(MixCurves, OfTooManyKnotsTogetherThereIsNone) {
    std::vector<Curve::Knot> many, more;
    for (int i = 0; i < 200; ++i) many.push_back({i / 200.0, 0.5});
    for (int i = 0; i < 100; ++i) more.push_back({(i + 0.25) / 100.0, 0.5});
    const ColoredCurve a{Curve::create(many).value()}, b{Curve::create(more).value()};
    EXPECT_FALSE(canMix(a, b));
    EXPECT_TRUE(canMix(a, a));
}

glm::dmat4 anyTransform(Random& random) {
    glm::dmat4 transform = glm::translate(glm::dmat4(1.0), 3.0 * random.direction());
    transform = glm::rotate(transform, random.between(-3.0, 3.0), random.direction());
    for (int i = 0; i < 3; ++i) {
        transform = glm::rotate(transform, random.between(-3.0, 3.0), random.direction());
        transform = glm::scale(transform, glm::dvec3(random.magnitude(-3, 3), random.magnitude(-3, 3), 1.0));
    }
    return transform;
}

double difference(const glm::dmat4& a, const glm::dmat4& b) {
    double most = 0.0;
    for (int i = 0; i < 16; ++i) most = std::max(most, std::abs(a[i / 4][i % 4] - b[i / 4][i % 4]));
    return most;
}

TEST(MixTransforms, MeetTheirEndsAndStayInvertible) {
    Random random(44);
    for (int i = 0; i < 500; ++i) {
        const auto a = anyTransform(random), b = anyTransform(random);
        const glm::dmat4 mirror = glm::scale(glm::dmat4(1.0), glm::dvec3(-1.0, 1.0, 1.0));
        EXPECT_TRUE(canMixTransforms(a, b));
        EXPECT_TRUE(canMixTransforms(a * mirror, b * mirror));
        EXPECT_FALSE(canMixTransforms(a, b * mirror));
        EXPECT_LT(difference(mixTransforms(a, b, 1e-9), a), 1e-5);
        EXPECT_LT(difference(mixTransforms(a, b, 1.0 - 1e-9), b), 1e-5);
        const double least = std::min(glm::determinant(a), glm::determinant(b));
        for (const double share : {0.1, 0.5, 0.9}) {
            EXPECT_GT(glm::determinant(mixTransforms(a, b, share)), 0.999 * least);
            EXPECT_LT(glm::determinant(mixTransforms(a * mirror, b * mirror, share)), -0.999 * least);
        }
    }
}

TEST(MixTransforms, StretchAndTurnEvenly) {
    const double right = glm::half_pi<double>();
    const glm::dmat4 a = glm::scale(glm::dmat4(1.0), glm::dvec3(2.0));
    const glm::dmat4 b = glm::rotate(glm::translate(glm::dmat4(1.0), glm::dvec3(4.0, 0.0, 0.0)), right,
                                     glm::dvec3(0.0, 0.0, 1.0)) *
                         glm::scale(glm::dmat4(1.0), glm::dvec3(4.0));
    const glm::dmat4 half = glm::rotate(glm::translate(glm::dmat4(1.0), glm::dvec3(2.0, 0.0, 0.0)),
                                        0.5 * right, glm::dvec3(0.0, 0.0, 1.0)) *
                            glm::scale(glm::dmat4(1.0), glm::dvec3(3.0));
    EXPECT_LT(difference(mixTransforms(a, b, 0.5), half), 1e-12);
}

TEST(StepsBetween, EachIsShownEquallyLong) {
    for (const auto& [from, to] : {std::pair{0U, 5U}, {5U, 0U}, {7U, 9U}, {3U, 3U}}) {
        const unsigned steps = (from > to ? from - to : to - from) + 1;
        std::vector<double> held(10), blended(10);
        constexpr int samples = 60000;
        for (int i = 0; i < samples; ++i) {
            const double share = (i + 0.5) / samples;
            for (const auto& shown : stepsPlayed(from, to, share, BetweenSteps::hold))
                held[shown.step] += shown.weight;
            double sum = 0.0;
            for (const auto& shown : stepsPlayed(from, to, share, BetweenSteps::blend)) {
                blended[shown.step] += shown.weight;
                sum += shown.weight;
            }
            ASSERT_NEAR(sum, 1.0, 1e-12);
        }
        for (unsigned step = std::min(from, to); step <= std::max(from, to); ++step) {
            EXPECT_NEAR(held[step], samples / steps, 2.0);
            EXPECT_NEAR(blended[step], samples / steps, 4.0);
        }
        EXPECT_EQ(stepsPlayed(from, to, 0.0, BetweenSteps::hold), (std::vector<ShownStep>{{from, 1.0}}));
        EXPECT_EQ(stepsPlayed(from, to, 1.0, BetweenSteps::hold), (std::vector<ShownStep>{{to, 1.0}}));
        EXPECT_EQ(stepsPlayed(from, to, 1.0, BetweenSteps::blend), (std::vector<ShownStep>{{to, 1.0}}));
    }
}

TEST(StepsBetween, KeyframesHaveTheirOwn) {
    using Shown = std::vector<ShownStep>;
    EXPECT_EQ(stepsBetween(2, 6, 0.49, BetweenSteps::hold), (Shown{{3, 1.0}}));
    EXPECT_EQ(stepsBetween(2, 6, 0.5, BetweenSteps::hold), (Shown{{4, 1.0}}));
    EXPECT_EQ(stepsBetween(6, 2, 0.5, BetweenSteps::hold), (Shown{{4, 1.0}}));
    EXPECT_EQ(stepsBetween(2, 6, 0.5 - 1e-13, BetweenSteps::hold), (Shown{{4, 1.0}})) << "rounding";
    EXPECT_EQ(stepsBetween(2, 6, 0.625, BetweenSteps::blend), (Shown{{4, 0.5}, {5, 0.5}}));
    EXPECT_EQ(stepsBetween(6, 2, 0.625, BetweenSteps::blend), (Shown{{4, 0.5}, {3, 0.5}}));
    EXPECT_EQ(stepsBetween(2, 6, 1.0, BetweenSteps::blend), (Shown{{6, 1.0}}));
}

}  // namespace
}  // namespace mote::test
