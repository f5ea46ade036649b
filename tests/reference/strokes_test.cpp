// SPDX-License-Identifier: GPL-3.0-or-later
//
// The reference's strokes against closed forms: the ink of lines and areas, their depth.
#include <gtest/gtest.h>

#include <numbers>

#include "tests/reference/reference_renderer.h"
#include "tests/support/view_text.h"

namespace mote::reference {
namespace {

using render::StrokePoint;
using render::Strokes;

/// 40 x 40 pixels in front of black, the eye 4 away; white strokes and nothing else.
Picture picture(Strokes strokes) {
    strokes.color = glm::vec3(1.0F);
    const render::Scene scene{
        test::viewOf("{'width': 40, 'height': 40, 'camera': {'eye': [0, 0, 4], 'target': [0, 0, 0]}}"), {}};
    return render(scene, {.strokes = {std::make_shared<const Strokes>(std::move(strokes))}});
}

Picture lineOf(std::vector<StrokePoint> points) {
    const auto end = static_cast<std::uint32_t>(points.size());
    return picture(
        {.points = std::move(points), .lines = {{0, end}}, .outlines = {}, .areas = {}, .areaDepths = {}});
}

Picture areaOf(std::vector<StrokePoint> points, double depth = 4.0) {
    const auto end = static_cast<std::uint32_t>(points.size());
    std::vector<float> depths(40 * 40, static_cast<float>(depth));
    // A pixel that has no depth.
    depths[30 * 40 + 4] = render::AreaDepths::none;
    return picture({.points = std::move(points),
                    .lines = {},
                    .outlines = {{0, end}},
                    .areas = {{0, 1}},
                    .areaDepths = {40, 40, std::move(depths)}});
}

double strokesInk(const Picture& picture) {
    double sum = 0.0;
    for (const auto& color : picture.linear) sum += color.x;
    return sum;
}

TEST(ReferenceStrokes, ALineHasAsMuchInkAsItIsWide) {
    for (const float width : {0.1F, 0.8F, 1.0F, 3.3F, 7.0F}) {
        for (const float y : {12.0F, 12.4F, 12.5F})
            EXPECT_NEAR(strokesInk(lineOf({{-9.0F, y, width, 4.0}, {60.0F, y, width, 4.0}})), 40.0 * width,
                        1e-4);
    }
}

TEST(ReferenceStrokes, AWideLineIsOneInside) {
    const auto drawn = lineOf({{-9.0F, 20.0F, 7.0F, 4.0}, {60.0F, 20.0F, 7.0F, 4.0}});
    for (std::uint32_t row = 17; row < 23; ++row) EXPECT_EQ(drawn.at(20, row).x, 1.0) << row;
    EXPECT_EQ(drawn.at(20, 24).x, 0.0);
}

TEST(ReferenceStrokes, APointIsADot) {
    const auto drawn = lineOf({{20.0F, 20.0F, 12.0F, 4.0}});
    EXPECT_NEAR(strokesInk(drawn), std::numbers::pi * 36.0, 0.5);
}

TEST(ReferenceStrokes, AnAreaIsWhatItsOutlinesSurround) {
    const std::vector<StrokePoint> triangle{{3.0F, 3.0F}, {33.0F, 3.0F}, {3.0F, 23.0F}};
    EXPECT_NEAR(strokesInk(areaOf(triangle)), 300.0, 1e-9);
    // A star of five points is hollow in the middle.
    std::vector<StrokePoint> star;
    for (int i = 0; i < 5; ++i) {
        const double angle = 0.8 * i * std::numbers::pi;
        star.push_back({static_cast<float>(20.0 + 15.0 * std::sin(angle)),
                        static_cast<float>(20.0 - 15.0 * std::cos(angle))});
    }
    EXPECT_EQ(areaOf(star).at(20, 20).x, 0.0);
    EXPECT_EQ(areaOf(star).at(19, 9).x, 1.0);
}

TEST(ReferenceStrokes, AnAreaIsNotDrawnWhereItHasNoDepth) {
    const std::vector<StrokePoint> square{{2.0F, 28.0F}, {8.0F, 28.0F}, {8.0F, 34.0F}, {2.0F, 34.0F}};
    EXPECT_NEAR(strokesInk(areaOf(square)), 35.0, 1e-9);
    EXPECT_EQ(areaOf(square).at(4, 30).x, 0.0);
    EXPECT_EQ(areaOf(square).at(5, 30).x, 1.0);
}

TEST(ReferenceStrokes, NothingIsNearerThanWhatIsSeen) {
    EXPECT_EQ(strokesInk(lineOf({{20.0F, 20.0F, 12.0F, 0.003}})), 0.0);
    EXPECT_GT(strokesInk(lineOf({{20.0F, 20.0F, 12.0F, 0.005}})), 0.0);
    EXPECT_EQ(strokesInk(areaOf({{3.0F, 3.0F}, {33.0F, 3.0F}, {3.0F, 23.0F}}, 0.003)), 0.0);
}

}  // namespace
}  // namespace mote::reference
