// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ranks/frame_order.h"

#include <gtest/gtest.h>

namespace mote::render {
namespace {

/// Nothing as it is by default.
FieldPlan unlikeTheDefault() {
    FieldPlan field{
        .layer = 3,
        .boxToEye = glm::dmat4(2.5),
        .boxToLayer = glm::dmat3(0.25),
        .transfer = {.opacity = Curve::create({{-400.0, 0.0}, {1300.0, 0.9}}, -1000.0, 3000.0).value(),
                     .opacityLength = 0.125,
                     .fade = 0.5,
                     .colorMap = ColorMap::find("viridis").value(),
                     .colorRange = {-300.0, 1200.0},
                     .colors = {glm::dvec3(0.1, 0.2, 0.3), glm::dvec3(0.9, 0.8, 0.7)},
                     .span = {-500.0, 1500.0}},
        .clips = {{glm::dvec3(1.0, 0.0, 0.0), 20.0}, {glm::dvec3(0.0, 0.0, -1.0), -3.0}},
        .samples = {}};
    CorrectedField samples{.grid = {}, .bricks = false, .correction = 0.7, .steepness = 8.0};
    samples.shades.fill({0.5F, 0.25F});
    field.samples = samples;
    return field;
}

void expectSame(const FieldPlan& arrived, const FieldPlan& sent) {
    EXPECT_EQ(arrived.layer, sent.layer);
    EXPECT_EQ(arrived.boxToEye, sent.boxToEye);
    EXPECT_EQ(arrived.boxToLayer, sent.boxToLayer);
    EXPECT_EQ(arrived.transfer, sent.transfer);
    EXPECT_EQ(arrived.clips, sent.clips);
    ASSERT_EQ(arrived.samples.index(), sent.samples.index());
    if (sent.grid() == nullptr) return;
    EXPECT_EQ(arrived.grid()->bricks, sent.grid()->bricks);
    EXPECT_EQ(arrived.grid()->correction, sent.grid()->correction);
    EXPECT_EQ(arrived.grid()->steepness, sent.grid()->steepness);
    EXPECT_EQ(arrived.grid()->shades, sent.grid()->shades);
}

TEST(FrameOrder, FieldsArrive) {
    FrameOrder order;
    order.plan.width = 64;
    order.plan.height = 48;
    const TransferFunction density{.opacity = Curve::constant(0.5), .opacityLength = 1.0};
    order.plan.fields = {{.layer = 1, .transfer = density, .samples = DensityField{}}, unlikeTheDefault()};
    order.fieldSteps = {{"data/beam.mote/step-000000.h5", "digest"},
                        {"data/ct.mote/step-000003.h5", "other", HybridRepresentation::points}};
    const auto arrived = unpackOrder(packOrder(order));
    EXPECT_EQ(arrived.plan.width, 64U);
    EXPECT_EQ(arrived.plan.height, 48U);
    EXPECT_EQ(arrived.fieldSteps, order.fieldSteps);
    ASSERT_EQ(arrived.plan.fields.size(), order.plan.fields.size());
    for (std::size_t i = 0; i < order.plan.fields.size(); ++i)
        expectSame(arrived.plan.fields[i], order.plan.fields[i]);
}

TEST(FrameOrder, PointsArrive) {
    FrameOrder order;
    const PointsPlan points{
        .layer = 2,
        .step = {},
        .boxToEye = glm::dmat4(1.5),
        .look = {.size = 2.0, .opacity = 0.25, .color = glm::dvec3(0.1, 0.2, 0.3), .thinned = 0.5},
        .fraction = Curve::create({{0.0, 1.0}, {0.5, 0.0}}).value(),
        .selection = std::make_shared<const PointSelection>(),
        .leavesInView = {5, 6, 7},
        .preview = {},
        .pointsDrawn = 12345,
        .share = 0.75};
    order.plan.points = {points};
    order.pointSteps = {{.file = "data/beam.mote/step-000000.h5", .digest = "digest", .selection = "some"}};
    order.flatPoints = 0;
    const std::vector<glm::vec3> colors{glm::vec3(0.1F, 0.2F, 0.3F), glm::vec3(1.0F)};
    order.colors = {
        std::make_shared<const PixelColors>(3, 2, colors, std::vector<std::uint16_t>{0, 1, 1, 0, 0, 1}),
        nullptr};
    const auto arrived = unpackOrder(packOrder(order));
    EXPECT_EQ(arrived.flatPoints, order.flatPoints);
    EXPECT_EQ(arrived.pointSteps, order.pointSteps);
    ASSERT_EQ(arrived.plan.points.size(), 1U);
    const PointsPlan& one = arrived.plan.points[0];
    EXPECT_EQ(one.layer, points.layer);
    EXPECT_EQ(one.boxToEye, points.boxToEye);
    EXPECT_EQ(one.look, points.look);
    EXPECT_EQ(one.fraction, points.fraction);
    EXPECT_NE(one.selection, nullptr) << "of no leaves";
    EXPECT_EQ(one.leavesInView, points.leavesInView);
    EXPECT_EQ(one.pointsDrawn, points.pointsDrawn);
    EXPECT_EQ(one.share, points.share);
    ASSERT_EQ(arrived.colors.size(), 2U);
    ASSERT_NE(arrived.colors[0], nullptr);
    EXPECT_EQ(arrived.colors[0]->width(), 3U);
    EXPECT_EQ(arrived.colors[0]->height(), 2U);
    EXPECT_EQ(arrived.colors[0]->colors(), colors);
    EXPECT_EQ(arrived.colors[0]->places(), order.colors[0]->places());
    EXPECT_EQ(arrived.colors[1], nullptr);
}

TEST(FrameOrder, StrokesArrive) {
    FrameOrder order;
    Strokes strokes;
    strokes.points = {{1.0F, 2.0F, 3.0F, 4.0}, {5.0F, 6.0F, 7.0F, 8.0}, {9.0F, 1.0F}};
    strokes.lines = {{0, 2}};
    strokes.outlines = {{0, 3}};
    strokes.areas = {{0, 1}};
    strokes.areaDepths = {2, 1, {1.0F, AreaDepths::none}};
    strokes.color = {0.1F, 0.2F, 0.3F};
    strokes.opacity = 0.4F;
    order.plan.strokes = {std::make_shared<const Strokes>(strokes)};
    const auto arrived = unpackOrder(packOrder(order));
    ASSERT_EQ(arrived.plan.strokes.size(), 1U);
    EXPECT_EQ(*arrived.plan.strokes[0], strokes);
}

}  // namespace
}  // namespace mote::render
