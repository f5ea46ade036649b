// SPDX-License-Identifier: GPL-3.0-or-later
//
// The channel's maps against closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "preprocess/synth/fodo_channel.h"

namespace mote::prep {
namespace {

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
