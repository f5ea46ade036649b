// SPDX-License-Identifier: GPL-3.0-or-later
//
// Each device's volumes against the reference, with no points but of what is too thin for them: no other
// hides what they do wrong.
#include <gtest/gtest.h>

#include "tests/golden/device_pictures.h"
#include "tests/golden/golden_files.h"
#include "tests/golden/golden_scenes.h"
#include "tests/reference/reference_renderer.h"

namespace mote::test {
namespace {

class DeviceVolumeTest : public testing::TestWithParam<std::tuple<std::string, GoldenScene>> {};

TEST_P(DeviceVolumeTest, MeetsTheReference) {
    const auto& [kind, golden] = GetParam();
    auto scene = makeScene(golden.name);
    for (auto& layer : scene.view.layers) {
        if (layer.particles()) layer.particles()->pointFraction = Curve::constant(0.0);
    }
    const auto reference = reference::render(scene, {golden.referenceSamples});
    const auto expected = reference::encode(reference);
    const auto actual = picture(*deviceOf(kind), scene, render::Quality::exact());
    const auto result = compare(actual, expected, reference.ambiguous);
    RecordProperty("result", result.toString());
    const bool good = result.within(golden.limits);
    EXPECT_TRUE(good) << result.toString();
    if (good && !keepAll()) return;
    const auto name = golden.name + "-volume-" + kind;
    keep(actual, name);
    if (result.sameShape) keep(difference(actual, expected), name + "-difference");
}

INSTANTIATE_TEST_SUITE_P(All, DeviceVolumeTest,
                         testing::Combine(testing::ValuesIn(deviceKinds()),
                                          testing::ValuesIn(goldenScenes())),
                         [](const auto& both) {
                             return std::get<0>(both.param) + '_' + std::get<1>(both.param).name;
                         });

}  // namespace
}  // namespace mote::test
