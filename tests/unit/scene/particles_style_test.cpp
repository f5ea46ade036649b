// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/particles_style.h"

#include <gtest/gtest.h>

#include <cmath>

#include "protocol/scene/srgb.h"

namespace mote {
namespace {

Curve curve(std::vector<Curve::Knot> knots) {
    return Curve::create(std::move(knots)).value();
}

ParticlesStyle styleOf(const proto::ParticlesStyle& message) {
    return particlesStyleOf(parseParticlesStyle(message).value());
}

TEST(LinkedFraction, IsOneMinusTheNormalisedOpacity) {
    const auto volume = curve({{0.2, 0.0}, {0.6, 0.1}, {0.6, 0.4}, {1.0, 0.2}});
    const auto points = linkedFraction(volume);
    for (int i = 0; i <= 1000; ++i) {
        const double t = i / 1000.0;
        EXPECT_NEAR(points(t), 1.0 - volume(t) / 0.4, 1e-12) << t;
    }
}

TEST(LinkedFraction, WithoutAVolumeAllPointsAreDrawn) {
    EXPECT_EQ(linkedFraction(Curve::constant(0.0))(0.5), 1.0);
    EXPECT_EQ(linkedFraction(curve({{0.0, 0.0}, {1.0, 0.0}}))(0.9), 1.0);
}

TEST(LinkedFraction, AnEvenVolumeLeavesNone) {
    EXPECT_EQ(linkedFraction(Curve::constant(0.3))(0.5), 0.0);
}

TEST(ParticlesStyle, DefaultsAreTheDocumentedOnes) {
    const auto style = styleOf({});
    EXPECT_EQ(style.pointOpacity, 0.25);
    EXPECT_EQ(style.pointSize, 1.0);
    EXPECT_EQ(style.colorMap.name(), "inferno");
    EXPECT_EQ(style.pointColor, srgbToLinear(glm::dvec3(1.0, 0.85, 0.6)));
    EXPECT_EQ(style.pointFraction, linkedFraction(style.volumeOpacity));
    EXPECT_GT(style.volumeOpacity.maximum(), 0.0);
    EXPECT_EQ(particlesStyleOf(parseParticlesStyle({}).value(), 1440).pointSize, 2.0) << "of 720 lines: 1";
}

TEST(ParticlesStyle, WhatIsNotSaidIsLeftToThePlot) {
    proto::ParticlesStyle message;
    auto style = styleOf(message);
    EXPECT_TRUE(style.curveByPlot && style.opacityByPlot && style.sizeByPlot);
    message.mutable_points()->set_opacity(0.25);
    message.mutable_points()->set_size_pixels(1.0);
    message.mutable_points()->set_linked(false);
    message.mutable_points()->add_curve()->set_fraction(1.0);
    style = styleOf(message);
    EXPECT_FALSE(style.curveByPlot || style.opacityByPlot || style.sizeByPlot);
}

TEST(ParticlesStyle, WhatIsLeftToThePlotStaysSo) {
    const auto style = parseParticlesStyle({}).value();
    EXPECT_EQ(parseParticlesStyle(style).value().SerializeAsString(), style.SerializeAsString());
    EXPECT_TRUE(style.volume().curve().empty());
    EXPECT_FALSE(style.points().has_opacity() || style.points().has_size_pixels());
}

TEST(ParticlesStyle, PointsThatGiveWayToTheVolumeAreLinkedWhoeverSaysIt) {
    proto::ParticlesStyle message;
    auto& points = *message.mutable_points();
    points.set_linked(false);
    auto* knot = points.add_curve();
    knot->set_density(0.62);
    knot->set_fraction(1.0);
    points.add_curve()->set_density(0.82);
    const auto style = parseParticlesStyle(message).value();
    EXPECT_EQ(style.volume().curve_size(), 2) << "a curve beside which points have their own is said";
    EXPECT_TRUE(style.points().linked());
    EXPECT_TRUE(style.points().curve().empty());
    points.mutable_curve(0)->set_fraction(0.9);
    EXPECT_FALSE(parseParticlesStyle(message).value().points().linked());
}

TEST(ParticlesStyle, ExtinctionGivesTheOpacityOverItsLength) {
    proto::ParticlesStyle message;
    auto* knot = message.mutable_volume()->add_curve();
    knot->set_opacity(0.3);
    const auto transfer = styleOf(message).transfer();
    // exp(-extinction / 32) is what a ray through 1/32 leaves.
    EXPECT_NEAR(std::exp(-transfer.extinction(0.5) / 32.0), 0.7, 1e-12);
    EXPECT_NEAR(transfer.extinction(-0.0625), 0.5 * transfer.extinction(0.0), 1e-12);
    EXPECT_EQ(transfer.extinction(-0.125), 0.0);
    EXPECT_EQ(transfer.extinction(-1.0), 0.0);
    EXPECT_EQ(transfer.extinction(2.0), transfer.extinction(1.0));
}

TEST(ParticlesStyle, FullOpacityStaysFinite) {
    proto::ParticlesStyle message;
    message.mutable_volume()->add_curve()->set_opacity(1.0);
    message.mutable_points()->set_opacity(1.0);
    const auto style = styleOf(message);
    EXPECT_TRUE(std::isfinite(style.transfer().extinction(0.5)));
    EXPECT_EQ(style.pointOpacity, ParticlesStyle::opacityLimit);
    // What is left is less than half an 8-bit step of sRGB near black.
    EXPECT_LT(linearToSrgb(1.0 - ParticlesStyle::opacityLimit), 0.5 / 255.0);
}

TEST(ParticlesStyle, UnlinkedPointsHaveTheirOwnCurve) {
    proto::ParticlesStyle message;
    message.mutable_points()->set_linked(false);
    auto* knot = message.mutable_points()->add_curve();
    knot->set_density(0.5);
    knot->set_fraction(0.25);
    EXPECT_EQ(styleOf(message).pointFraction, Curve::create({{0.5, 0.25}}).value());
}

TEST(ParticlesStyle, PointsHaveACurveWhereTheyAreNotLinked) {
    const auto whereOf = [](const proto::ParticlesStyle& message) {
        return parseParticlesStyle(message).error().toString().substr(0, 13);
    };
    proto::ParticlesStyle message;
    message.mutable_points()->add_curve();
    EXPECT_EQ(whereOf(message), "points.curve:");
    message.mutable_points()->set_linked(true);
    EXPECT_EQ(whereOf(message), "points.curve:");
    message.mutable_points()->set_linked(false);
    EXPECT_TRUE(parseParticlesStyle(message).ok());
    message.mutable_points()->clear_curve();
    EXPECT_EQ(whereOf(message), "points.curve:");
}

}  // namespace
}  // namespace mote
