// SPDX-License-Identifier: GPL-3.0-or-later
//
// The golden scenes themselves: each shows what its name says, so that a device cannot pass with half a
// picture.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tests/golden/comparison.h"
#include "tests/golden/golden_scenes.h"
#include "tests/reference/reference_renderer.h"
#include "tests/reference/scene_styles.h"

namespace mote::test {
namespace {

/// The share of pixels that differ by more than what counts as close.
double changedShare(const Image& one, const Image& other) {
    return 1.0 - compare(one, other).closeShare;
}

/// Few samples are enough to see whether something is there.
Image quickly(const render::Scene& scene) {
    return reference::encode(reference::render(scene, {2.0}));
}

class GoldenSceneTest : public testing::TestWithParam<GoldenScene> {};

TEST_P(GoldenSceneTest, ShowsVolumePointsAndDots) {
    const auto scene = makeScene(GetParam().name);
    const auto whole = quickly(scene);
    const auto empty =
        quickly({View{scene.view.width, scene.view.height, 1.0, scene.view.background, {}, {}, {}}, {}});
    auto noVolume = scene, noPoints = scene;
    auto noMesh = scene;
    for (std::size_t i = 0; i < scene.view.layers.size(); ++i) {
        if (auto* const style = std::get_if<MeshStyle>(&noMesh.view.layers[i].style)) style->set_opacity(0.0);
        if (!scene.view.layers[i].particles()) continue;
        particlesIn(noVolume, i).volumeOpacity = Curve::constant(0.0);
        particlesIn(noPoints, i).pointFraction = Curve::constant(0.0);
    }
    const double covered = changedShare(whole, empty);
    const double volume = changedShare(whole, quickly(noVolume));
    const double points = changedShare(whole, quickly(noPoints));
    auto noDots = scene;
    noDots.dots = {};
    EXPECT_GE(changedShare(whole, quickly(noDots)), GetParam().dotsShare);
    EXPECT_GE(changedShare(whole, quickly(noMesh)), GetParam().meshShare);
    EXPECT_GE(covered, GetParam().coveredShare);
    EXPECT_GE(volume, GetParam().volumeShare);
    EXPECT_GE(points, GetParam().pointsShare);
    RecordProperty("covered", std::to_string(covered));
    RecordProperty("volume", std::to_string(volume));
    RecordProperty("points", std::to_string(points));
    if (keepAll()) keep(whole, GetParam().name + "-quick");
}

class GoldenHybridTest : public testing::TestWithParam<GoldenScene> {};

/// Against the same scene without its layers, and without its corrections or points.
TEST_P(GoldenHybridTest, ShowsVolumeAndWhatSetsItRight) {
    const auto scene = makeScene(GetParam().name);
    const auto whole = quickly(scene);
    const auto empty =
        quickly({View{scene.view.width, scene.view.height, 1.0, scene.view.background, {}, {}, {}}, {}});
    auto low = scene;
    for (auto& layer : low.view.layers) {
        if (auto* const style = std::get_if<proto::HybridStyle>(&layer.style))
            style->set_representation("volume");
    }
    const double covered = changedShare(whole, empty), righted = changedShare(whole, quickly(low));
    EXPECT_GE(covered, GetParam().coveredShare);
    EXPECT_GE(righted, GetParam().pointsShare);
    RecordProperty("covered", std::to_string(covered));
    RecordProperty("righted", std::to_string(righted));
}

INSTANTIATE_TEST_SUITE_P(All, GoldenHybridTest, testing::ValuesIn(goldenHybrids()),
                         [](const auto& scene) { return scene.param.name; });

TEST(GoldenScenes, HaveTheirOwnNames) {
    std::set<std::string> names;
    for (const auto& scene : goldenHybrids()) EXPECT_TRUE(names.insert(scene.name).second) << scene.name;
    for (const auto& scene : goldenColors()) EXPECT_TRUE(names.insert(scene.name).second) << scene.name;
    for (const auto& scene : goldenScenes()) EXPECT_TRUE(names.insert(scene.name).second) << scene.name;
    EXPECT_GE(names.size(), 6U);
}

INSTANTIATE_TEST_SUITE_P(Colors, GoldenSceneTest, testing::ValuesIn(goldenColors()),
                         [](const auto& scene) { return scene.param.name; });

INSTANTIATE_TEST_SUITE_P(All, GoldenSceneTest, testing::ValuesIn(goldenScenes()),
                         [](const auto& scene) { return scene.param.name; });

}  // namespace
}  // namespace mote::test
