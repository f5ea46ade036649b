// SPDX-License-Identifier: GPL-3.0-or-later

#include <gtest/gtest.h>
#include <cmath>
#include <glm/geometric.hpp>
#include "protocol/scene/fields/resolve.h"
#include "server/render/layers/make_frame_plan.h"
#include "server/render/plan/hidden_area.h"
#include "tests/reference/scene_styles.h"
#include "tests/support/beams.h"
#include "tests/support/memory_step.h"
#include "tests/support/view_text.h"

namespace mote::render {
namespace {

Scene beamScene(std::string_view view) {
    static const auto step =
        test::MemoryStep::make(test::beam({.core = 8000, .halo = 2000, .filaments = 1000}));
    Scene scene{test::viewOf(view), {}};
    scene.layers.assign(scene.view.layers.size(), {.step = step});
    return scene;
}

const char* const plain =
    "{'width': 200, 'height': 100, 'camera': {'eye': [0, 0, 4], 'target': [0, 0, 0]},"
    "'layers': [{'particles': {'points': {'opacity': 0.5, 'sizePixels': 3}}}]}";

TEST(FramePlan, TakesTheViewAsItIsAtFullQuality) {
    const auto scene = beamScene(plain);
    const auto plan = makeFramePlan(scene, Quality::exact());
    EXPECT_EQ(plan.width, 200U);
    EXPECT_EQ(plan.height, 100U);
    EXPECT_EQ(plan.camera, scene.view.camera);
    EXPECT_EQ(plan.slabs, Quality::exact().slabs);
    ASSERT_EQ(plan.points.size(), 1U);
    const auto style = particlesStyleOf(*scene.view.layers[0].particles());
    EXPECT_EQ(plan.points[0].look.size, style.pointSize);
    EXPECT_NEAR(plan.points[0].look.opacity, style.pointOpacity, 1e-15);
    EXPECT_EQ(plan.points[0].look.color, style.pointColor);
    EXPECT_EQ(plan.points[0].fraction, style.pointFraction);
    ASSERT_EQ(plan.fields.size(), 1U);
    ASSERT_NE(plan.fields[0].density(), nullptr);
    EXPECT_EQ(plan.fields[0].density()->step, scene.layers[0].step);
    EXPECT_EQ(plan.fields[0].transfer, style.transfer());
    EXPECT_EQ(plan.points[0].step, scene.layers[0].step);
    std::uint64_t drawn = 0;
    for (std::size_t i = 0; i < scene.layers[0].step->leaves().size(); ++i) drawn += plan.points[0].drawn(i);
    EXPECT_EQ(plan.points[0].pointsDrawn, drawn);
    EXPECT_GT(plan.points[0].pointsDrawn, 0U);
}

TEST(FramePlan, DepthsEncloseTheBox) {
    // Seen along z from 4 away, the box of edge 2 begins at depth 3 and ends at 5.
    const auto plan = makeFramePlan(beamScene(plain), Quality::exact());
    EXPECT_NEAR(plan.nearDepth, 3.0, 1e-12);
    EXPECT_NEAR(plan.farDepth, 5.0, 1e-12);
}

TEST(FramePlan, DepthsBeginInFrontOfAPerspectiveEyeAndBehindAnOrthographicOne) {
    const auto perspective = makeFramePlan(
        beamScene("{'width': 9, 'height': 9, 'camera': {'eye': [0, 0, 0.5], 'target': [0, 0, 0]},"
                  "'layers': [{'particles': {}}]}"),
        Quality::exact());
    EXPECT_NEAR(perspective.nearDepth, nearShare * 0.5, 1e-12);
    EXPECT_NEAR(perspective.farDepth, 1.5, 1e-12);
    const auto orthographic = makeFramePlan(
        beamScene("{'width': 9, 'height': 9, 'camera': {'eye': [0, 0, 0.5], 'target': [0, 0, 0],"
                  "'orthographicHeight': 2}, 'layers': [{'particles': {}}]}"),
        Quality::exact());
    EXPECT_NEAR(orthographic.nearDepth, -0.5, 1e-12);
    EXPECT_NEAR(orthographic.farDepth, 1.5, 1e-12);
}

TEST(FramePlan, ABoxBehindTheEyeLeavesNoDepthsAndNoPoints) {
    const auto plan =
        makeFramePlan(beamScene("{'width': 9, 'height': 9, 'camera': {'eye': [0, 0, 4], 'target': [0, 0, 8]},"
                                "'layers': [{'particles': {}}]}"),
                      Quality::exact());
    EXPECT_EQ(plan.nearDepth, plan.farDepth);
    EXPECT_EQ(plan.points[0].pointsDrawn, 0U);
}

TEST(FramePlan, DepthsEncloseAllLayers) {
    const auto plan = makeFramePlan(
        beamScene(
            "{'width': 9, 'height': 9, 'camera': {'eye': [0, 0, 4], 'target': [0, 0, 0]}, 'layers': ["
            "{'particles': {}}, {'transform': [1,0,0,0, 0,1,0,0, 0,0,1,-2, 0,0,0,1], 'particles': {}}]}"),
        Quality::exact());
    EXPECT_NEAR(plan.nearDepth, 3.0, 1e-12);
    EXPECT_NEAR(plan.farDepth, 7.0, 1e-12);
}

TEST(FramePlan, LowerResolutionKeepsThePointsInProportion) {
    const auto plan = makeFramePlan(beamScene(plain), {.resolutionScale = 0.5});
    EXPECT_EQ(plan.width, 100U);
    EXPECT_EQ(plan.height, 50U);
    EXPECT_DOUBLE_EQ(plan.points[0].look.size, 1.5);
    const auto least = makeFramePlan(beamScene(plain), {.resolutionScale = 1e-6});
    EXPECT_EQ(least.width, 1U);
    EXPECT_EQ(least.height, 1U);
}

TEST(FramePlan, FewerPointsAreAPrefixAndMoreOpaque) {
    const auto scene = beamScene(plain);
    const auto all = makeFramePlan(scene, Quality::exact());
    const auto some = makeFramePlan(scene, {.pointFraction = 0.25});
    // A point of which a quarter is drawn, by chance, leaves as much on average: 1 - a/4, a being twice as
    // much.
    EXPECT_NEAR(some.points[0].look.opacity, 0.95, 1e-12) << "at most";
    EXPECT_NEAR(some.points[0].look.opacity * discArea(some.points[0].look.size) * 0.25,
                0.5 * discArea(all.points[0].look.size), 1e-9);
    const std::size_t count = scene.layers[0].step->leaves().size();
    for (std::size_t i = 0; i < count; ++i) EXPECT_LE(some.points[0].drawn(i), all.points[0].drawn(i));
    // Each leaf rounds by less than a point, at random: three standard deviations of a sum over the leaves.
    const auto leaves = static_cast<double>(count);
    EXPECT_NEAR(static_cast<double>(some.points[0].pointsDrawn),
                0.25 * static_cast<double>(all.points[0].pointsDrawn), 3.0 * std::sqrt(0.5 * leaves));
}

TEST(FramePlan, PicturesOfOneStepAndStyleShareTheirSelection) {
    SelectionCache selections;
    auto scene = beamScene(plain);
    const auto first = makeFramePlan(scene, Quality::exact(), selections, {});
    scene.view.camera.eye = {3.0, 0.0, 0.0};
    const auto turned = makeFramePlan(scene, Quality::exact(), selections, {});
    EXPECT_EQ(turned.points[0].selection, first.points[0].selection);
    const auto quick = makeFramePlan(scene, {.pointFraction = 0.5}, selections, {});
    EXPECT_NE(quick.points[0].selection, first.points[0].selection);
    test::particlesIn(scene).pointFraction = Curve::constant(0.5);
    EXPECT_NE(makeFramePlan(scene, Quality::exact(), selections, {}).points[0].selection,
              first.points[0].selection);
}

TEST(FramePlan, OpacityStaysBelowItsLimit) {
    auto scene = beamScene(plain);
    test::particlesIn(scene).pointOpacity = ParticlesStyle::opacityLimit;
    const auto plan = makeFramePlan(scene, {.pointFraction = 0.01});
    EXPECT_LE(plan.points[0].look.opacity, ParticlesStyle::opacityLimit);
    EXPECT_GT(plan.points[0].look.size, 10.0 * makeFramePlan(scene, Quality::exact()).points[0].look.size);
}

TEST(FramePlan, ALayerThatFadesIsThinned) {
    auto scene = beamScene(plain);
    const auto whole = makeFramePlan(scene, Quality::exact());
    EXPECT_EQ(whole.points[0].look.thinned, 1.0);
    for (const double opacity : {0.999, 0.3, 1e-6, 1e-300}) {
        scene.view.layers[0].opacity = opacity;
        for (const auto& quality : {Quality::exact(), Quality{.pointFraction = 0.25}}) {
            const auto plan = makeFramePlan(scene, quality);
            EXPECT_EQ(plan.points[0].look.thinned, opacity);
            EXPECT_EQ(plan.points[0].look.opacity,
                      makeFramePlan(beamScene(plain), quality).points[0].look.opacity);
            EXPECT_EQ(plan.fields[0].density()->strength, opacity);
            EXPECT_EQ(plan.fields[0].transfer, whole.fields[0].transfer);
        }
    }
}

TEST(FramePlan, OfALayerOfWhichThereIsNothingNothingIsPlanned) {
    auto scene = beamScene(plain);
    scene.view.layers.resize(5, scene.view.layers[0]);
    scene.view.layers[1].style = *parseHybridStyle({});
    scene.view.layers[2].style = resolved(MeshStyle()).value();
    scene.view.layers[3].style = *parseInkStyle({}, glm::dvec3(0.0));
    scene.view.layers[4].transform[3][2] = 100.0;
    for (std::size_t i = 1; i < 5; ++i) scene.view.layers[i].opacity = 0.0;
    scene.layers.resize(5);
    const auto plan = makeFramePlan(scene, Quality::exact());
    const auto alone = makeFramePlan(beamScene(plain), Quality::exact());
    EXPECT_EQ(plan.points.size(), 1U);
    EXPECT_EQ(plan.fields.size(), 1U);
    EXPECT_FALSE(plan.anyDots());
    EXPECT_EQ(plan.nearDepth, alone.nearDepth);
    EXPECT_EQ(plan.farDepth, alone.farDepth);
    scene.view.layers[0].opacity = 0.0;
    EXPECT_TRUE(makeFramePlan(scene, Quality::exact()).blank());
}

TEST(FramePlan, LeavesOutOfViewAreNotDrawn) {
    const auto plan = makeFramePlan(
        beamScene("{'width': 90, 'height': 90, 'camera': {'eye': [0.7, 0, 4], 'target': [0.7, 0, 0],"
                  "'orthographicHeight': 0.6}, 'layers': [{'particles': {'points': {'linked': false,"
                  "'curve': [{'density': 0, 'fraction': 1}]}}}]}"),
        Quality::exact());
    EXPECT_GT(plan.points[0].pointsDrawn, 0U);
    EXPECT_LT(plan.points[0].pointsDrawn, 3000U);  // of 11000, the core with 8000 out of view
}

}  // namespace
}  // namespace mote::render
