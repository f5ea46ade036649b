// SPDX-License-Identifier: GPL-3.0-or-later
//
// What lies over the points of a layer: docs/PICTURE.md, "Highlights" and "Paths".
#include <gtest/gtest.h>

#include <algorithm>

#include "server/render/layers/make_frame_plan.h"
#include "server/render/layers/particles/lower_particles.h"
#include "server/render/layers/particles/point_paths.h"
#include "tests/support/memory_step.h"
#include "tests/support/view_text.h"

namespace mote::render {
namespace {

std::shared_ptr<const test::MemoryStep> stepOf(const std::vector<glm::dvec3>& places) {
    std::vector<test::WeightedPoint> points;
    for (const auto& place : places) points.push_back({place, 1.0});
    return test::MemoryStep::make(points);
}

/// Seen along z by an orthographic eye: depth grows against z.
Scene highlighted(const std::vector<glm::dvec3>& places, const std::string& more) {
    const auto step = stepOf(places);
    Scene scene{test::viewOf("{'width': 64, 'height': 64, 'background': [0.2, 0.4, 0.6],"
                             "'camera': {'eye': [0, 0, 4], 'target': [0, 0, 0], 'orthographicHeight': 2},"
                             "'layers': [{'particles': {}, " +
                             more + "}]}"),
                {{.step = step, .highlight = step}}};
    return scene;
}

Fragments highlightOf(const FramePlan& plan) {
    Fragments fragments;
    plan.surfaces.at(0)->make({0, 0, plan.width, plan.height}, fragments);
    return fragments;
}

/// Brightness of the highlight's fragments from left to right, over that of its colour.
std::vector<double> shadesOf(const Scene& scene, const Quality& quality = Quality::exact()) {
    const auto plan = makeFramePlan(scene, quality);
    auto fragments = highlightOf(plan);
    std::ranges::sort(fragments, {}, &Fragment::column);
    std::vector<double> shades;
    const double whole = scene.view.layers[0].highlight->color.y;
    for (const auto& one : fragments) shades.push_back(static_cast<double>(one.color.y) / whole);
    return shades;
}

const char* const small = "'highlight': {'selection': {}, 'sizePixels': 1}";

TEST(Highlight, IsShadedByTheDepthOfItsPoints) {
    // Two depths: each is a standard deviation off their mean.
    const auto shades = shadesOf(highlighted({{0.2, 0.5, 0.9}, {0.8, 0.5, 0.1}}, small));
    ASSERT_EQ(shades.size(), 2U);
    EXPECT_NEAR(shades[0], 1.0 - 0.75 / 3.0, 1e-3);
    EXPECT_NEAR(shades[1], 0.25, 1e-3);
}

TEST(Highlight, OfOneDepthIsOfOneShade) {
    const auto shades = shadesOf(highlighted({{0.2, 0.5, 0.3}, {0.5, 0.5, 0.3}, {0.8, 0.5, 0.3}}, small));
    ASSERT_EQ(shades.size(), 3U);
    for (const double shade : shades) EXPECT_NEAR(shade, 0.5, 2e-3);
}

TEST(Highlight, APixelIsShadedByItsNearestPoint) {
    const std::vector<glm::dvec3> behind{{0.2, 0.5, 0.9}, {0.2, 0.5, 0.1}, {0.8, 0.5, 0.1}, {0.8, 0.5, 0.1}};
    const auto shades = shadesOf(highlighted(behind, small));
    ASSERT_EQ(shades.size(), 2U);
    EXPECT_GT(shades[0], 0.7) << "near";
    EXPECT_LT(shades[1], 0.4) << "far";
}

TEST(Highlight, AnEdgeOfANearDiscDoesNotShadeAFarOneUnderIt) {
    // The near disc covers less than half of the pixels that both touch between their middles.
    const auto scene = highlighted({{0.5, 0.5, 0.95}, {0.5 + 6.2 / 64.0, 0.5, 0.05}},
                                   "'highlight': {'selection': {}, 'sizePixels': 8}");
    const auto plan = makeFramePlan(scene, Quality::exact());
    const double whole = scene.view.layers[0].highlight->color.y;
    for (const auto& one : highlightOf(plan)) {
        const double fromNear = std::hypot(one.column + 0.5 - 32.0, one.row + 0.5 - 32.0);
        const double fromFar = std::hypot(one.column + 0.5 - 38.2, one.row + 0.5 - 32.0);
        const double shade = static_cast<double>(one.color.y) / whole;
        if (fromNear < 3.9) {
            EXPECT_NEAR(shade, 0.75, 2e-3);
        } else if (fromNear > 4.1 && fromFar < 3.9) {
            EXPECT_NEAR(shade, 0.25, 2e-3);
        }
    }
}

TEST(Paths, LieOnACasingInTheBackground) {
    const auto step = stepOf({{0.5, 0.5, 0.5}});
    Scene scene{test::viewOf("{'width': 640, 'height': 360, 'background': [0.2, 0.4, 0.6],"
                             "'layers': [{'particles': {}, 'paths': {'ids': [3], 'width': 4}}]}"),
                {{.step = step}}};
    scene.layers[0].paths = std::make_shared<const PointPaths>(
        PointPaths{.places = {{-0.5, 0.0, 0.0}, {0.5, 0.1, 0.3}, {0.5, 0.4, 0.0}}, .begin = {0, 3}});
    const auto plan = makeFramePlan(scene, Quality::exact());
    ASSERT_EQ(plan.strokes.size(), 2U);
    const Strokes &path = *plan.strokes[0], &casing = *plan.strokes[1];
    EXPECT_EQ(path.color, glm::vec3(particlesStyleOf(scene, 0).pointColor));
    EXPECT_EQ(casing.color, glm::vec3(scene.view.background));
    EXPECT_EQ(casing.lines, path.lines);
    ASSERT_EQ(casing.points.size(), path.points.size());
    for (std::size_t i = 0; i < path.points.size(); ++i) {
        EXPECT_FLOAT_EQ(path.points[i].width, 4.0F);
        EXPECT_FLOAT_EQ(casing.points[i].width, 5.0F) << "half a pixel of 360 lines on both sides";
        EXPECT_EQ(casing.points[i].depth, path.points[i].depth);
        EXPECT_EQ(casing.points[i].x, path.points[i].x);
    }
}

}  // namespace
}  // namespace mote::render
