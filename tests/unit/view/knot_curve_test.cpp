// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/knot_curve.h"

#include <gtest/gtest.h>

#include "client/view/layers/hybrid_editor.h"
#include "protocol/scene/hybrid_style.h"
#include "protocol/scene/srgb.h"

namespace mote::client {
namespace {

KnotCurve bones() {
    KnotCurve curve;
    curve.setValues({-1000.0, 1500.0});
    const auto& preset = tomographyPresets()[0];
    curve.take(preset.knots, preset.colors);
    return curve;
}

KnotCurve mapped() {
    KnotCurve curve = bones();
    curve.dropColors();
    return curve;
}

TEST(KnotCurve, IsWrittenAndReadAsItIs) {
    for (const KnotCurve& curve : {bones(), mapped()}) {
        HybridControls controls, read;
        controls.curve = curve;
        proto::HybridStyle style;
        controls.write(style);
        const auto parsed = parseHybridStyle(style);
        ASSERT_TRUE(parsed.ok()) << parsed.error().toString();
        EXPECT_EQ(hybridStyleOf(*parsed).opacity->knots(), curve.knots());
        EXPECT_EQ(hybridStyleOf(*parsed).colors.size(), curve.colors().size());
        read.curve.setValues({-1000.0, 1500.0});
        read.read(style);
        EXPECT_EQ(read.curve, curve);
    }
}

TEST(KnotCurve, KnotsStayInOrderAndOnTheAxis) {
    KnotCurve curve = mapped();
    const auto before = curve.knots();
    curve.move(1, {5000.0, 3.0});
    EXPECT_EQ(curve.knots()[1], (Curve::Knot{before[2].x, 1.0}));
    curve.move(0, {-5000.0, -1.0});
    EXPECT_EQ(curve.knots()[0], (Curve::Knot{-1000.0, 0.0}));
}

TEST(KnotCurve, TheAxisShowsEveryKnot) {
    KnotCurve curve = mapped();
    curve.setValues({0.0, 200.0});  // of another step, say
    EXPECT_EQ(curve.axis(), (Interval{0.0, curve.knots().back().x}));
    curve.move(3, {10000.0, 0.5});
    EXPECT_EQ(curve.axis().high, tomographyPresets()[0].knots.back().x);
}

TEST(KnotCurve, ANewKnotChangesNothingButWhereItIsPut) {
    KnotCurve curve = bones();
    const glm::dvec3 color = curve.color(300.0);
    EXPECT_EQ(curve.insert({300.0, 0.7}), 2U);
    ASSERT_EQ(curve.colors().size(), curve.knots().size());
    EXPECT_EQ(curve.knots()[2], (Curve::Knot{300.0, 0.7}));
    // The colour goes through sRGB in single precision.
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(curve.color(300.0)[i], color[i], 1e-6);
    curve.remove(2);
    EXPECT_EQ(curve, bones());
}

TEST(KnotCurve, TheLastKnotStays) {
    KnotCurve curve = bones();
    for (int i = 0; i < 10; ++i) curve.remove(0);
    EXPECT_EQ(curve.knots().size(), 1U);
    EXPECT_EQ(curve.colors().size(), 1U);
    EXPECT_LT(curve.extent().low, curve.extent().high);
    EXPECT_EQ(curve.color(-5000.0), curve.color(5000.0));
}

TEST(KnotCurve, TheChosenKnotsColorIsEdited) {
    KnotCurve curve = bones();
    curve.choose(2);
    *curve.chosenColor() = {1.0F, 0.0F, 0.0F};
    EXPECT_EQ(curve.color(curve.knots()[2].x), glm::dvec3(1.0, 0.0, 0.0));
    for (int i = 0; i < 3; ++i) curve.remove(0);
    EXPECT_NE(curve.chosenColor(), nullptr);  // what was chosen is gone: another one
    curve.dropColors();
    EXPECT_EQ(curve.chosenColor(), nullptr);
}

TEST(KnotCurve, AnEmptyStyleIsAnInvisibleCurve) {
    HybridControls controls;
    controls.curve = bones();
    controls.read({});
    ASSERT_EQ(controls.curve.knots().size(), 1U);
    EXPECT_EQ(controls.curve.knots()[0].y, 0.0);
}

}  // namespace
}  // namespace mote::client
