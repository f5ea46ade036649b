// SPDX-License-Identifier: GPL-3.0-or-later
//
// The core's field against what determines it: Gauss's law inside and outside, continuity at the edge, 1/r^2
// far away; and the kick polynomial against the exact field.
#include "preprocess/synth/envelope.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace mote::prep {
namespace {

using Point = std::array<double, 3>;

constexpr std::array<Point, 4> shapes{
    {{4e-3, 2e-3, 4e-3}, {6e-3, 2e-3, 3e-3}, {2e-3, 2e-3, 2e-3}, {1e-3, 3e-3, 2e-3}}};

Point squared(const Point& axes) {
    return {axes[0] * axes[0], axes[1] * axes[1], axes[2] * axes[2]};
}

/// A point at `radius` times the edge in a random direction.
Point pointAt(const Point& axes, double radius, std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    Point u{normal(random), normal(random), normal(random)};
    const double length = std::sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
    return {axes[0] * radius * u[0] / length, axes[1] * radius * u[1] / length,
            axes[2] * radius * u[2] / length};
}

double derivative(const Point& squares, Point point, std::size_t component, std::size_t along) {
    const double h = 1e-6;  // m: truncation (h / size)^2 ~ 1e-6, rounding 1e-16 size / h ~ 1e-13
    Point back = point;
    point[along] += h;
    back[along] -= h;
    return (ellipsoidField(squares, point)[component] - ellipsoidField(squares, back)[component]) / (2.0 * h);
}

TEST(CoreField, carlsonRdHasItsPublishedValues) {
    // Carlson 1995, section 3, and R_D(x, x, x) = x^(-3/2).
    EXPECT_NEAR(carlsonRd(0.0, 2.0, 1.0), 1.7972103521033883, 1e-14);
    EXPECT_NEAR(carlsonRd(2.0, 3.0, 4.0), 0.16510527294261053, 1e-15);
    EXPECT_NEAR(carlsonRd(4.0, 4.0, 4.0), 0.125, 1e-16);
}

TEST(CoreField, gaussInsideAndOutside) {
    std::mt19937_64 random(1);
    for (const Point& axes : shapes) {
        const Point squares = squared(axes);
        // div E = 4 pi rho = 3 / (a b c) for a charge of 1 over 4 pi eps0.
        const double inside = 3.0 / (axes[0] * axes[1] * axes[2]);
        for (const double radius : {0.2, 0.9, 1.1, 2.0, 5.0}) {
            for (int i = 0; i < 20; ++i) {
                const Point point = pointAt(axes, radius, random);
                double divergence = 0.0;
                for (std::size_t axis = 0; axis < 3; ++axis)
                    divergence += derivative(squares, point, axis, axis);
                EXPECT_NEAR(divergence / inside, radius < 1.0 ? 1.0 : 0.0, 1e-5) << radius;
                const double curl = derivative(squares, point, 0, 1) - derivative(squares, point, 1, 0);
                EXPECT_NEAR(curl / inside, 0.0, 1e-5) << radius;
            }
        }
    }
}

TEST(CoreField, continuousAtTheEdgeAndLinearInside) {
    std::mt19937_64 random(2);
    for (const Point& axes : shapes) {
        const Point squares = squared(axes);
        const Point form = ellipsoidForm(squares);
        for (int i = 0; i < 50; ++i) {
            const Point in = pointAt(axes, 1.0 - 1e-9, random);
            const Point out{in[0] * (1.0 + 2e-9), in[1] * (1.0 + 2e-9), in[2] * (1.0 + 2e-9)};
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double inner = ellipsoidField(squares, in)[axis];
                EXPECT_NEAR(inner, form[axis] * in[axis], 1e-12 * std::abs(inner));
                // The field changes by some 1e-9 of its greatest value over the gap.
                EXPECT_NEAR(ellipsoidField(squares, out)[axis], inner, 2e-8 * form[axis] * axes[axis]);
            }
        }
    }
}

TEST(CoreField, farAwayIsAPointCharge) {
    std::mt19937_64 random(3);
    for (const Point& axes : shapes) {
        for (const double radius : {20.0, 200.0}) {
            const Point point = pointAt(axes, radius, random);
            const double r = std::sqrt(point[0] * point[0] + point[1] * point[1] + point[2] * point[2]);
            const Point field = ellipsoidField(squared(axes), point);
            const double greatest = std::max({axes[0], axes[1], axes[2]});
            // The quadrupole moment's part is at most 3/2 * (2/5) a^2 / r^2 of the monopole's.
            for (std::size_t axis = 0; axis < 3; ++axis) {
                EXPECT_NEAR(field[axis] * r * r, point[axis] / r, greatest * greatest / (r * r));
            }
        }
    }
}

TEST(CoreField, aSphereIsCoulombsLaw) {
    const double a = 3e-3;
    const Point squares{a * a, a * a, a * a};
    EXPECT_NEAR(ellipsoidField(squares, {1e-3, 0.0, 0.0})[0], 1e-3 / (a * a * a), 1e-9 * 1e-3 / (a * a * a));
    const Point out = ellipsoidField(squares, {0.0, -8e-3, 6e-3});
    EXPECT_NEAR(out[1], -0.8 / 1e-4, 1e-8);
    EXPECT_NEAR(out[2], 0.6 / 1e-4, 1e-8);
}

// A long bunch is a continuous beam of line density 3/(4c) at its middle: the field inside is 2 * 3/(4c) * 2
// x / (a (a+b)) over 4 pi eps0, the term 2K/(a+b) of the two-dimensional envelope equations.
TEST(CoreField, aLongBunchIsAContinuousBeam) {
    const double a = 3e-3, b = 2e-3, c = 3.0;
    const Point form = ellipsoidForm({a * a, b * b, c * c});
    // The next term is of the order (a/c)^2 ln(c/a) ~ 1e-5.
    EXPECT_NEAR(form[0] * c * a * (a + b) / 3.0, 1.0, 2e-5);
    EXPECT_NEAR(form[1] * c * b * (a + b) / 3.0, 1.0, 2e-5);
}

TEST(CoreField, theKickPolynomialIsTheExactFormToAMillionth) {
    for (const Point& axes : shapes) {
        const double strength = 4e-9;
        const CoreKick kick = coreKick(axes, strength);
        for (int i = 0; i <= 400; ++i) {
            const double t = 0.0025 * i;
            if (t == 0.0) continue;
            const double lambda = kick.scale / t - kick.scale;
            const Point form =
                ellipsoidForm({kick.squares[0] + lambda, kick.squares[1] + lambda, kick.squares[2] + lambda});
            for (std::size_t plane = 0; plane < 3; ++plane) {
                double value = 0.0;
                for (std::size_t n = CoreKick::terms; n-- > 0;) {
                    value = value * (2.0 * t - 1.0) + kick.coefficients[plane][n];
                }
                EXPECT_NEAR(t * std::sqrt(t) * value / (strength * form[plane]), 1.0, 1e-6) << t;
            }
        }
    }
}

TEST(CoreField, theConfocalCoordinateSolvesItsEquation) {
    std::mt19937_64 random(4);
    for (const Point& axes : shapes) {
        const Point squares = squared(axes);
        EXPECT_EQ(confocalCoordinate(squares, {0.0, 0.0, 0.0}), 0.0);
        EXPECT_EQ(confocalCoordinate(squares, pointAt(axes, 0.99, random)), 0.0);
        for (const double radius : {1.001, 1.5, 4.0, 30.0}) {
            const Point p = pointAt(axes, radius, random);
            const double lambda = confocalCoordinate(squares, p);
            double sum = 0.0;
            for (std::size_t i = 0; i < 3; ++i) sum += p[i] * p[i] / (squares[i] + lambda);
            EXPECT_NEAR(sum, 1.0, 1e-13);
        }
    }
}

}  // namespace
}  // namespace mote::prep
