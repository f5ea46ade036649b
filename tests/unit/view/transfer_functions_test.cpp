// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/layers/transfer_functions.h"

#include <gtest/gtest.h>

#include "protocol/scene/curve_presets.h"
#include "protocol/scene/particles_style.h"

namespace mote::client {
namespace {

using Which = TransferFunctions::Which;

TransferFunctions ramp() {
    proto::ParticlesStyle style;
    for (const auto& [density, opacity] : {std::pair{0.4, 0.0}, {0.7, 0.1}, {0.9, 0.2}}) {
        auto* knot = style.mutable_volume()->add_curve();
        knot->set_density(density);
        knot->set_opacity(opacity);
    }
    TransferFunctions functions;
    functions.read(style);
    return functions;
}

/// What a server would make of them.
ParticlesStyle parsed(const TransferFunctions& functions) {
    proto::ParticlesStyle message;
    functions.write(message);
    return particlesStyleOf(parseParticlesStyle(message).value());
}

TEST(TransferFunctions, LinkedPointsMirrorTheVolume) {
    const auto functions = ramp();
    EXPECT_DOUBLE_EQ(functions.knots(Which::points)[1].y, 0.5);
    EXPECT_EQ(parsed(functions).pointFraction.knots(), functions.knots(Which::points));
}

TEST(TransferFunctions, EditingThePointsEditsTheVolumeWhileLinked) {
    auto functions = ramp();
    functions.move(Which::points, 1, {0.6, 0.75});
    EXPECT_DOUBLE_EQ(functions.knots(Which::volume)[1].x, 0.6);
    EXPECT_DOUBLE_EQ(functions.knots(Which::volume)[1].y, 0.05);
    EXPECT_DOUBLE_EQ(functions.knots(Which::points)[1].y, 0.75);
}

TEST(TransferFunctions, TheKnotThatHoldsTheGreatestOpacityKeepsItWhileLinked) {
    auto functions = ramp();
    functions.move(Which::points, 2, {0.95, 0.9});
    EXPECT_EQ(functions.knots(Which::volume)[2], (Curve::Knot{0.95, 0.2}));
}

TEST(TransferFunctions, UnlinkedCurvesAreIndependent) {
    auto functions = ramp();
    functions.setLinked(false);
    const auto volume = functions.knots(Which::volume);
    functions.move(Which::points, 0, {0.1, 0.3});
    EXPECT_EQ(functions.knots(Which::volume), volume);
    EXPECT_EQ(parsed(functions).pointFraction.knots(), functions.knots(Which::points));
}

TEST(TransferFunctions, LinkingAgainMakesThePointsFollow) {
    auto functions = ramp();
    functions.setLinked(false);
    functions.move(Which::points, 0, {0.1, 0.3});
    functions.setLinked(true);
    EXPECT_TRUE(functions.linked());
    for (const Which which : {Which::volume, Which::points})
        EXPECT_EQ(functions.knots(which), ramp().knots(which));
}

TEST(TransferFunctions, LinkingForgetsNoCurve) {
    auto functions = ramp();
    functions.setLinked(false);
    EXPECT_DOUBLE_EQ(functions.knots(Which::points)[1].y, 0.5);  // where they were while linked
    functions.move(Which::points, 1, {0.6, 0.25});
    const auto own = functions.knots(Which::points);
    functions.setLinked(true);
    functions.move(Which::volume, 1, {0.7, 0.05});
    proto::ParticlesStyle message;
    functions.write(message);
    functions.read(message);  // as each frame does
    EXPECT_NE(functions.knots(Which::points), own);
    functions.setLinked(false);
    EXPECT_EQ(functions.knots(Which::points), own);
    EXPECT_DOUBLE_EQ(functions.knots(Which::volume)[1].y, 0.05);
}

TEST(TransferFunctions, UnlinkedWithoutACurveOfTheirOwnPointsStayWhereTheyAre) {
    auto functions = ramp();
    functions.setLinked(false);
    functions.setLinked(true);
    functions.move(Which::volume, 1, {0.7, 0.05});
    const auto points = functions.knots(Which::points);
    functions.setLinked(false);
    EXPECT_EQ(functions.knots(Which::points), points);
}

TEST(TransferFunctions, KnotsStayInOrderAndRange) {
    auto functions = ramp();
    functions.move(Which::volume, 1, {5.0, -3.0});
    EXPECT_EQ(functions.knots(Which::volume)[1], (Curve::Knot{0.9, 0.0}));
}

TEST(TransferFunctions, InsertAndRemoveOnEitherCurve) {
    for (const Which which : {Which::volume, Which::points}) {
        for (const bool linked : {true, false}) {
            auto functions = ramp();
            functions.setLinked(linked);
            const auto before = functions.knots(which).size();
            const auto knot = functions.insert(which, {0.5, 0.25});
            EXPECT_EQ(functions.knots(which).size(), before + 1);
            EXPECT_DOUBLE_EQ(functions.knots(which)[knot].x, 0.5);
            functions.remove(which, knot);
            EXPECT_EQ(functions.knots(which).size(), before);
        }
    }
}

TEST(TransferFunctions, TheLastKnotStaysAndEmptyVolumesDrawAllPoints) {
    auto functions = ramp();
    for (int i = 0; i < 5; ++i) functions.remove(Which::volume, 0);
    ASSERT_EQ(functions.knots(Which::volume).size(), 1U);
    functions.move(Which::volume, 0, {0.5, 0.0});
    EXPECT_DOUBLE_EQ(functions.knots(Which::points)[0].y, 1.0);
    functions.move(Which::points, 0, {0.5, 0.2});  // nothing to measure by: no change, no crash
    EXPECT_TRUE(parsed(functions).volumeOpacity.maximum() == 0.0);
}

TEST(TransferFunctions, PresetsAreReadAsWrittenAndLeftToThePlotAgain) {
    const auto plain = TransferFunctions();
    for (const auto& preset : densityPresets()) {
        auto functions = plain;
        functions.take(preset.opacity, preset.fraction);
        EXPECT_EQ(parsed(functions).volumeOpacity.knots(), preset.opacity) << preset.name;
        EXPECT_EQ(parsed(functions).pointFraction.knots(), preset.fraction) << preset.name;
        proto::ParticlesStyle message;
        functions.leaveToPlot();
        functions.write(message);
        EXPECT_TRUE(message.volume().curve().empty()) << preset.name;
    }
}

}  // namespace
}  // namespace mote::client
