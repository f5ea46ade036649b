// SPDX-License-Identifier: GPL-3.0-or-later
//
// The core's field against what determines it: Gauss's law inside and outside, continuity at the edge, 1/r^2
// far away; and the kick polynomial against the exact field.
#include <gtest/gtest.h>
#include <cmath>
#include <random>

#include "preprocess/synth/envelope.h"
#include "preprocess/synth/fodo_channel.h"

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

// The channel's maps against closed forms.

double determinant(const PlaneMap& map) {
    return map.uu * map.pp - map.up * map.pu;
}

TEST(Channel, constantFocusingIsCosineOrHyperbolicCosine) {
    for (const double k : {90.0, 2.5, 1e-9}) {
        for (const double length : {0.01, 0.035, 0.105}) {
            const double phi = std::sqrt(k) * length;
            const PlaneMap focus = constantFocusing(k, length);
            EXPECT_NEAR(focus.uu, std::cos(phi), 4e-16);
            EXPECT_NEAR(focus.up, std::sin(phi) / std::sqrt(k), 4e-16);
            EXPECT_NEAR(focus.pu, -std::sqrt(k) * std::sin(phi), 4e-14);
            const PlaneMap defocus = constantFocusing(-k, length);
            EXPECT_NEAR(defocus.uu, std::cosh(phi), 4e-16 * std::cosh(phi));
            EXPECT_NEAR(defocus.up, std::sinh(phi) / std::sqrt(k), 4e-16);
        }
    }
    const PlaneMap drift = constantFocusing(0.0, 0.14);
    EXPECT_EQ(drift.uu, 1.0);
    EXPECT_EQ(drift.up, 0.14);
    EXPECT_EQ(drift.pu, 0.0);
}

// Thick-lens FODO cell of quadrupoles l and drifts d, theta = sqrt(k) l (Reiser, Theory and Design of Charged
// Particle Beams, section 3.8): cos mu = cos th cosh th + (d/l) th (cos th sinh th - sin th cosh th)
// - (d/l)^2 th^2 / 2 sin th sinh th. Both sides are exact, so only rounding is left.
TEST(Channel, phaseAdvanceWithoutCurrentIsTheThickLensFodoFormula) {
    for (const double gradient : {15.0, 25.0, 36.0, 42.0}) {
        BeamDesign design;
        design.quadrupoleGradient = gradient;
        design.rfFocusing = 0.0;
        const FodoChannel channel(design);
        const double l = design.quadrupoleLength, ratio = (0.5 * design.periodLength - l) / l;
        const double th = std::sqrt(gradient / (kinematics(design).momentum / speedOfLight)) * l;
        const double expected = std::cos(th) * std::cosh(th) +
                                ratio * th * (std::cos(th) * std::sinh(th) - std::sin(th) * std::cosh(th)) -
                                0.5 * ratio * ratio * th * th * std::sin(th) * std::sinh(th);
        ASSERT_LT(std::abs(expected), 1.0);
        EXPECT_NEAR(std::cos(channel.phaseAdvance(0)), expected, 1e-13);
        EXPECT_NEAR(std::cos(channel.phaseAdvance(1)), expected, 1e-13) << "y is x shifted by half a period";
    }
}

TEST(Channel, rfAloneIsAPlainOscillationAlongAndDefocusesHalfAsMuchAcross) {
    BeamDesign design;
    design.quadrupoleGradient = 0.0;
    const FodoChannel channel(design);
    EXPECT_NEAR(channel.phaseAdvance(2), std::sqrt(design.rfFocusing) * design.periodLength, 1e-13);
    const double phi = std::sqrt(0.5 * design.rfFocusing) * design.periodLength;
    const ChannelMap map = channel.map(0.0, design.periodLength);
    EXPECT_NEAR(map[0].uu, std::cosh(phi), 1e-13);
    EXPECT_NEAR(map[1].uu, std::cosh(phi), 1e-13);
}

TEST(Channel, mapsComposeAcrossEdgesAndPeriodsAndKeepAreas) {
    const FodoChannel channel{BeamDesign{}};
    const double begin = 0.013, middle = 0.4871, end = 1.333;
    const ChannelMap first = channel.map(begin, middle), second = channel.map(middle, end);
    const ChannelMap whole = channel.map(begin, end);
    for (std::size_t plane = 0; plane < 3; ++plane) {
        const PlaneMap both = second[plane].after(first[plane]);
        EXPECT_NEAR(both.uu, whole[plane].uu, 1e-12);
        EXPECT_NEAR(both.up, whole[plane].up, 1e-12);
        EXPECT_NEAR(both.pu, whole[plane].pu, 1e-11);
        EXPECT_NEAR(both.pp, whole[plane].pp, 1e-12);
        EXPECT_NEAR(determinant(whole[plane]), 1.0, 1e-12);
    }
}

TEST(Channel, aPeriodIsThatOfTheDesign) {
    const BeamDesign design;
    double length = 0.0;
    const FodoChannel channel(design);
    for (const ChannelElement& element : channel.elements()) {
        EXPECT_NEAR(element.begin, length, 1e-15);
        length += element.length;
        // div F = 0: what focuses in one plane defocuses in the others.
        EXPECT_NEAR(element.focusing[0] + element.focusing[1] + element.focusing[2], 0.0, 1e-12);
    }
    EXPECT_NEAR(length, design.periodLength, 1e-15);
}

// 6.7 MeV protons: gamma = 1 + 6.7 / 938.272, p c = sqrt(T^2 + 2 T m c^2).
TEST(Channel, kinematicsOfTheDesign) {
    const BeamKinematics beam = kinematics(BeamDesign{});
    EXPECT_NEAR(beam.gamma, 1.00714079, 1e-8);
    EXPECT_NEAR(beam.momentum, std::sqrt(6.7e6 * 6.7e6 + 2.0 * 6.7e6 * protonMassEv), 1e-3);
    EXPECT_NEAR(beam.beta, std::sqrt(1.0 - 1.0 / (beam.gamma * beam.gamma)), 1e-12);
    EXPECT_NEAR(beam.particlesPerBunch, 0.075 / 350e6 / elementaryCharge, 1.0);
    // e^2 / (4 pi eps0 m c^2) in the SI, eps0 of CODATA 2018.
    const double radius = elementaryCharge / (4.0 * M_PI * 8.8541878128e-12 * protonMassEv);
    EXPECT_NEAR(classicalProtonRadius / radius, 1.0, 1e-8);
}

}  // namespace
}  // namespace mote::prep
