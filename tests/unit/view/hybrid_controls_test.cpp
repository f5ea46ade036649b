// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/layers/hybrid_editor.h"

#include <gtest/gtest.h>

#include "protocol/scene/dataset.h"
#include "protocol/scene/hybrid_style.h"

namespace mote::client {
namespace {

/// 20 x 10 x 5 voxels of 2 x 2 x 4 units, the first one's centre at (1, 1, 2): a box from 0 to (40, 20, 20).
proto::HybridManifest volume(double low, double high, const std::string& unit = "") {
    proto::HybridManifest manifest;
    for (const unsigned size : {20U, 10U, 5U}) manifest.add_source_size(size);
    for (const double number : {2, 0, 0, 1, 0, 2, 0, 1, 0, 0, 4, 2, 0, 0, 0, 1})
        manifest.add_index_to_world(number);
    manifest.set_value_min(low);
    manifest.set_value_max(high);
    manifest.set_value_unit(unit);
    auto& step = *manifest.add_steps();
    for (int bin = 0; bin < 256; ++bin) step.add_histogram(bin < 50 ? 1000 : 10);
    return manifest;
}

/// All that a message can say.
proto::HybridStyle wholeStyle() {
    HybridControls controls;
    controls.setDataset(volume(0.0, 255.0));
    controls.rest.set_representation("points");
    controls.rest.set_point_shape("square");
    controls.rest.set_point_opacity(0.5);
    controls.colorMap = "viridis";
    controls.ownMap = true;
    controls.ownColorRange = true;
    controls.colorRange = {10.0F, 200.0F};
    auto& light = *controls.rest.mutable_light();
    assign(light.mutable_direction(), glm::dvec3(1.0, 0.0, 0.0));
    light.set_fixed(true);
    light.set_ambient(0.5);
    proto::HybridStyle style;
    controls.write(style);
    return style;
}

TEST(HybridControls, WhatIsSetIsWhatTheServerReads) {
    const auto parsed = parseHybridStyle(wholeStyle());
    ASSERT_TRUE(parsed.ok()) << parsed.error().toString();
    const auto style = hybridStyleOf(*parsed);
    EXPECT_EQ(style.representation, HybridRepresentation::points);
    EXPECT_EQ(style.pointShape, PointShape::square);
    EXPECT_EQ(style.pointOpacity, 0.5);
    EXPECT_EQ(style.colorMap.name(), "viridis");
    EXPECT_EQ(style.colorRange, (ValueRange{10.0, 200.0}));
    EXPECT_NEAR(style.light.direction.x, 1.0, 1e-6);
    EXPECT_TRUE(style.light.fixed);
    EXPECT_EQ(style.light.ambient, 0.5);
}

TEST(HybridControls, AStyleIsReadAsItWasWritten) {
    HybridControls controls;
    controls.read(wholeStyle());
    proto::HybridStyle again;
    controls.write(again);
    EXPECT_EQ(again.SerializeAsString(), wholeStyle().SerializeAsString());
}

void expectColor(const glm::dvec3& got, const glm::dvec3& wanted) {
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(got[i], wanted[i], 1e-12);
}

TEST(HybridControls, ColoursThatNobodyChoseAreThoseThatTheServerDraws) {
    const auto viridis = ColorMap::find("viridis").value();
    for (const bool said : {false, true}) {
        proto::HybridStyle message;
        for (const double value : {10.0, 20.0}) {
            auto& knot = *message.add_curve();
            knot.set_value(value);
            knot.set_opacity(0.5);
        }
        if (said) message.set_color_map("viridis");
        HybridControls controls;
        controls.read(*parseHybridStyle(message));
        controls.setDataset(volume(0.0, 255.0));
        expectColor(controls.color(10.0), viridis(said ? 0.0 : 0.4));
        expectColor(controls.color(20.0), viridis(1.0));
        proto::HybridStyle written;
        controls.write(written);
        EXPECT_EQ(written.color_map(), message.color_map());
        // A knot more leaves the colours where they were.
        const auto before = controls.curve.extent();
        controls.curve.take({{0.0, 0.1}, {10.0, 0.5}, {20.0, 0.5}}, {});
        controls.keepColors(before);
        expectColor(controls.color(10.0), viridis(said ? 0.0 : 0.4));
    }
}

TEST(HybridControls, GreatestValuesHaveColoursUpToTheHighest) {
    proto::HybridStyle message;
    for (const double value : {10.0, 20.0}) message.add_curve()->set_value(value);
    message.set_shows("maximum");
    HybridControls controls;
    controls.read(*parseHybridStyle(message));
    controls.setDataset(volume(0.0, 256.0));  // values up to the last bin
    const auto viridis = ColorMap::find("viridis").value();
    expectColor(controls.color(10.0), viridis(0.4));
    expectColor(controls.color(133.0), viridis(0.7));
    expectColor(controls.color(256.0), viridis(1.0));
}

TEST(HybridControls, ADatasetBringsACurveForItsValues) {
    HybridControls controls;
    controls.setDataset(volume(-1000.0, 2000.0));
    EXPECT_EQ(controls.curve.knots(), tomographyPresets()[0].knots);
    controls.setDataset(volume(0.0, 1.0));
    EXPECT_LE(controls.curve.knots().back().x, 1.0);
    const auto other = controls.curve.knots();
    controls.curve.move(0, {0.01, 0.0});
    controls.setDataset(volume(0.0, 1.0));  // the same values: the curve stays
    EXPECT_NE(controls.curve.knots(), other);
}

TEST(HybridControls, ASavedCurveStaysWithTheFirstDataset) {
    HybridControls controls;
    proto::HybridStyle style;
    style.add_curve()->set_value(0.25);
    controls.read(style);
    controls.setDataset(volume(0.0, 1.0));
    EXPECT_EQ(controls.curve.knots(), (std::vector<Curve::Knot>{{0.25, 0.0}}));
    HybridControls other;
    other.read(style);
    other.setDataset(volume(-3.0, 9.0));
    EXPECT_EQ(other.curve.axis(), (Interval{-3.0, 9.0}));
}

TEST(HybridControls, TheBoxHoldsWholeVoxels) {
    EXPECT_EQ(volumeBounds(volume(0.0, 1.0)), (Bounds{glm::dvec3(0.0), {40.0, 20.0, 20.0}}));
    EXPECT_EQ(volumeBounds({}), plotBounds);
}

TEST(HybridControls, AConstantVolumeHasAnAxis) {
    HybridControls controls;
    controls.setDataset(volume(7.0, 7.0));
    EXPECT_LT(controls.curve.axis().low, controls.curve.axis().high);
    proto::HybridStyle style;
    controls.write(style);
    EXPECT_TRUE(parseHybridStyle(style).ok());
}

}  // namespace
}  // namespace mote::client
