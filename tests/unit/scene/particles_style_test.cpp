// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/particles_style.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "protocol/scene/srgb.h"
#include "protocol/scene/style_kinds.h"

namespace mote {
namespace {

Curve curve(std::vector<Curve::Knot> knots) {
    return Curve::create(std::move(knots)).value();
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
    const auto style = parseParticlesStyle({});
    ASSERT_TRUE(style.ok());
    EXPECT_EQ(style->pointOpacity, 0.25);
    EXPECT_EQ(style->pointSize, 1.0);
    EXPECT_EQ(style->colorMap.name(), "inferno");
    EXPECT_EQ(style->pointColor, srgbToLinear(glm::dvec3(1.0, 0.85, 0.6)));
    EXPECT_EQ(style->pointFraction, linkedFraction(style->volumeOpacity));
    EXPECT_GT(style->volumeOpacity.maximum(), 0.0);
}

TEST(ParticlesStyle, WhatIsNotSaidIsLeftToThePlot) {
    proto::ParticlesStyle message;
    auto style = parseParticlesStyle(message).value();
    EXPECT_TRUE(style.curveByPlot && style.opacityByPlot && style.sizeByPlot);
    message.mutable_points()->set_opacity(0.25);
    message.mutable_points()->set_size_pixels(1.0);
    message.mutable_points()->set_linked(false);
    message.mutable_points()->add_curve()->set_fraction(1.0);
    style = parseParticlesStyle(message).value();
    EXPECT_FALSE(style.curveByPlot || style.opacityByPlot || style.sizeByPlot);
}

TEST(ParticlesStyle, WhatIsLeftToThePlotIsWrittenAsSuch) {
    const auto style = parseParticlesStyle({}).value();
    proto::Layer layer;
    writeStyle(style, glm::dvec3(0.0), layer);
    EXPECT_EQ(parseParticlesStyle(layer.particles()).value(), style);
    EXPECT_TRUE(layer.particles().volume().curve().empty());
    EXPECT_FALSE(layer.particles().points().has_opacity() || layer.particles().points().has_size_pixels());
}

TEST(ParticlesStyle, ExtinctionGivesTheOpacityOverItsLength) {
    proto::ParticlesStyle message;
    auto* knot = message.mutable_volume()->add_curve();
    knot->set_opacity(0.3);
    const auto transfer = parseParticlesStyle(message)->transfer();
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
    const auto style = parseParticlesStyle(message).value();
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
    const auto style = parseParticlesStyle(message);
    ASSERT_TRUE(style.ok());
    EXPECT_EQ(style->pointFraction, Curve::create({{0.5, 0.25}}).value());
}

struct Bad {
    const char* what;
    std::function<void(proto::ParticlesStyle&)> spoil;
    const char* where;
};

class BadStyle : public testing::TestWithParam<Bad> {};

TEST_P(BadStyle, IsAnErrorThatNamesItsField) {
    proto::ParticlesStyle message;
    GetParam().spoil(message);
    const auto result = parseParticlesStyle(message);
    ASSERT_FALSE(result.ok());
    EXPECT_EQ(result.error().where, GetParam().where);
    EXPECT_FALSE(result.error().message.empty());
}

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

void knot(proto::ParticlesStyle& m, double density, double opacity) {
    auto* added = m.mutable_volume()->add_curve();
    added->set_density(density);
    added->set_opacity(opacity);
}

INSTANTIATE_TEST_SUITE_P(
    All, BadStyle,
    testing::Values(
        Bad{"opacityOfKnot",
            [](auto& m) {
                knot(m, 0, 0.1);
                knot(m, 0.5, 1.1);
            },
            "volume.curve[1]"},
        Bad{"descending",
            [](auto& m) {
                knot(m, 0.5, 0.1);
                knot(m, 0.4, 0.1);
            },
            "volume.curve[1]"},
        Bad{"knotNan", [](auto& m) { knot(m, nan, 0.1); }, "volume.curve[0]"},
        Bad{"tooManyKnots",
            [](auto& m) {
                for (int i = 0; i < 257; ++i) knot(m, 0.5, 0.5);
            },
            "volume.curve"},
        Bad{"colorMap", [](auto& m) { m.mutable_volume()->set_color_map("jet"); }, "volume.colorMap"},
        Bad{"linkedWithCurve", [](auto& m) { m.mutable_points()->add_curve(); }, "points.curve"},
        Bad{"explicitlyLinkedWithCurve",
            [](auto& m) {
                m.mutable_points()->set_linked(true);
                m.mutable_points()->add_curve();
            },
            "points.curve"},
        Bad{"unlinkedWithoutCurve", [](auto& m) { m.mutable_points()->set_linked(false); }, "points.curve"},
        Bad{"fraction",
            [](auto& m) {
                m.mutable_points()->set_linked(false);
                m.mutable_points()->add_curve()->set_fraction(-1);
            },
            "points.curve[0]"},
        Bad{"pointOpacity", [](auto& m) { m.mutable_points()->set_opacity(1.5); }, "points.opacity"},
        Bad{"pointOpacityNan", [](auto& m) { m.mutable_points()->set_opacity(nan); }, "points.opacity"},
        Bad{"sizeZero", [](auto& m) { m.mutable_points()->set_size_pixels(0); }, "points.sizePixels"},
        Bad{"sizeTooLarge", [](auto& m) { m.mutable_points()->set_size_pixels(65); }, "points.sizePixels"},
        Bad{"colorShort", [](auto& m) { m.mutable_points()->add_color(1); }, "points.color"},
        Bad{"colorTooLarge",
            [](auto& m) {
                for (const double c : {0.5, 0.5, 1.5}) m.mutable_points()->add_color(c);
            },
            "points.color[2]"},
        Bad{"colorNegative",
            [](auto& m) {
                for (const double c : {0.5, -0.5, 0.5}) m.mutable_points()->add_color(c);
            },
            "points.color[1]"}),
    [](const auto& bad) { return bad.param.what; });

}  // namespace
}  // namespace mote
