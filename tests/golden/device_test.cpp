// SPDX-License-Identifier: GPL-3.0-or-later
//
// Each device against the reference: on each golden scene, its volumes alone, and strokes.
#include <gtest/gtest.h>

#include "tests/golden/comparison.h"
#include "tests/golden/device_pictures.h"
#include "tests/golden/golden_scenes.h"
#include "tests/golden/golden_strokes.h"
#include "tests/reference/reference_renderer.h"
#include "tests/reference/scene_styles.h"
#include "tests/support/view_text.h"

namespace mote::test {
namespace {

/// Holds a picture to the reference's, and keeps both, and how they differ, if it does not meet the limits.
void expectReference(const Image& actual, const reference::Picture& reference, const Limits& limits,
                     const std::string& name, const std::string& kind) {
    const auto expected = reference::encode(reference);
    const auto result = compare(actual, expected, reference.ambiguous);
    const bool good = result.within(limits);
    EXPECT_TRUE(good) << name << ": " << result.toString();
    if (good && !keepAll()) return;
    keep(actual, name + '-' + kind);
    keep(expected, name + "-reference");
    if (result.sameShape) keep(difference(actual, expected), name + '-' + kind + "-difference");
}

/// All devices are held to one picture of the reference's, which takes longer than theirs.
class DeviceGoldenTest : public testing::TestWithParam<GoldenScene> {
  protected:
    void meetsTheReference(const render::Scene& scene, const std::string& what) {
        const auto& golden = GetParam();
        const auto expected = reference::render(scene, {golden.referenceSamples});
        for (const auto& kind : deviceKinds()) {
            SCOPED_TRACE(kind);
            const auto actual = picture(*deviceOf(kind), scene, render::Quality::exact());
            expectReference(actual, expected, golden.limits, golden.name + what, kind);
        }
    }
};
/// Volumes with no points but of what is too thin for them: no other hides what they do wrong.
class DeviceVolumeTest : public DeviceGoldenTest {};

TEST_P(DeviceGoldenTest, MeetsTheReference) {
    meetsTheReference(makeScene(GetParam().name), "");
}

TEST_P(DeviceVolumeTest, MeetsTheReference) {
    auto scene = makeScene(GetParam().name);
    for (std::size_t i = 0; i < scene.view.layers.size(); ++i) {
        if (scene.view.layers[i].particles()) particlesIn(scene, i).pointFraction = Curve::constant(0.0);
    }
    meetsTheReference(scene, "-volume");
}

std::string nameOf(const testing::TestParamInfo<GoldenScene>& scene) {
    return scene.param.name;
}

INSTANTIATE_TEST_SUITE_P(All, DeviceGoldenTest, testing::ValuesIn(goldenScenes()), nameOf);
INSTANTIATE_TEST_SUITE_P(Hybrids, DeviceGoldenTest, testing::ValuesIn(goldenHybrids()), nameOf);
INSTANTIATE_TEST_SUITE_P(Colors, DeviceGoldenTest, testing::ValuesIn(goldenColors()), nameOf);
INSTANTIATE_TEST_SUITE_P(All, DeviceVolumeTest, testing::ValuesIn(goldenScenes()), nameOf);

// Each device's strokes against the reference: alone, and in one depth with what golden scenes show.

using render::Strokes;
using Lists = std::vector<std::shared_ptr<const Strokes>>;

class DeviceStrokesTest : public testing::TestWithParam<std::string> {
  protected:
    Image draw(const render::FramePlan& plan) {
        const auto drawn = device_->render(plan, render::PixelFormat::srgb8, {}).value();
        return {drawn.width, drawn.height, drawn.pixels};
    }
    void meetsTheReference(const render::Scene& scene, const render::FramePlan& plan, const std::string& name,
                           double samples, const Limits& limits = {}) {
        expectReference(draw(plan), reference::render(scene, {samples, plan.strokes}), limits, name,
                        GetParam());
    }

    std::unique_ptr<render::Device> device_ = deviceOf(GetParam());
};

/// 64 x 48 pixels, the eye 4 away from a black world without layers.
render::Scene emptyScene() {
    return {viewOf("{'width': 64, 'height': 48, 'camera': {'eye': [0, 0, 4], 'target': [0, 0, 0]}}"), {}};
}

int channelAt(const Image& image, std::size_t column, std::size_t row, std::size_t channel) {
    return image.pixels[4 * (row * image.width + column) + channel];
}

/// A green line across the middle of such a picture, 6 pixels wide.
std::shared_ptr<const Strokes> lineAt(double depth) {
    auto strokes = std::make_shared<Strokes>();
    strokes->points = {{-5.0F, 24.0F, 6.0F, depth}, {70.0F, 24.0F, 6.0F, depth}};
    strokes->lines = {{0, 2}};
    strokes->color = {0.0F, 1.0F, 0.0F};
    return strokes;
}

TEST_P(DeviceStrokesTest, GeneratedStrokesMeetTheReference) {
    const auto scene = emptyScene();
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        auto plan = makeFramePlan(scene, render::Quality::exact());
        plan.nearDepth = 3.0;
        plan.farDepth = 5.0;
        for (std::uint64_t list = 0; list < 3; ++list)
            plan.strokes.push_back(strokesFor(plan, 10 * seed + list));
        const auto lists = std::exchange(plan.strokes, {});
        for (const auto& strokes : lists) addStrokes(plan, strokes, 2.0, 6.0);
        meetsTheReference(scene, plan, "strokes-" + std::to_string(seed), 16.0);
    }
}

TEST_P(DeviceStrokesTest, MixInDepthWithWhatScenesShow) {
    for (const auto& golden : goldenScenes()) {
        if (golden.name != "dotShell" && golden.name != "meshShell" && golden.name != "dotsAlone") continue;
        const auto scene = makeScene(golden.name);
        auto plan = makeFramePlan(scene, render::Quality::exact());
        const auto strokes = strokesFor(plan, 5);
        addStrokes(plan, strokes, plan.nearDepth - 0.2, plan.farDepth + 0.2);
        // A fragment of a mesh is as deep as a 192nd of it; what lies in there is before or behind all of it.
        // Areas, at any depth, are in less than a third of the pixels: so in one of about 600 at most.
        auto limits = golden.limits;
        limits.closeShare -= 1.0 / 600.0;
        meetsTheReference(scene, plan, "strokes-" + golden.name, golden.referenceSamples, limits);
    }
}

TEST_P(DeviceStrokesTest, HideAndAreHidden) {
    auto scene = emptyScene();
    scene.dots = std::make_shared<const render::Dots>(
        render::Dots{{.x = 32.0F, .y = 24.0F, .depth = 4.0, .radius = 10.0F, .color = {1.0F, 0.0F, 0.0F}}});
    for (const double depth : {3.0, 5.0}) {
        auto plan = makeFramePlan(scene, render::Quality::exact());
        addStrokes(plan, lineAt(depth), depth - 0.1, depth + 0.1);
        const auto drawn = draw(plan);
        const bool front = depth < 4.0;
        EXPECT_EQ(channelAt(drawn, 32, 24, 0), front ? 0 : 255) << depth;
        EXPECT_EQ(channelAt(drawn, 32, 24, 1), front ? 255 : 0) << depth;
        EXPECT_EQ(channelAt(drawn, 10, 24, 1), 255) << depth;
        EXPECT_EQ(channelAt(drawn, 10, 30, 1), 0) << depth;
    }
}

TEST_P(DeviceStrokesTest, NothingIsNearerThanWhatIsSeen) {
    const auto scene = emptyScene();
    auto plan = makeFramePlan(scene, render::Quality::exact());
    addStrokes(plan, lineAt(render::nearLimit(plan.camera) / 2.0), 0.0, 1.0);
    EXPECT_EQ(channelAt(draw(plan), 32, 24, 1), 0);
}

INSTANTIATE_TEST_SUITE_P(All, DeviceStrokesTest, testing::ValuesIn(deviceKinds()),
                         [](const auto& kind) { return kind.param; });

}  // namespace
}  // namespace mote::test
