// SPDX-License-Identifier: GPL-3.0-or-later
//
// Each device against the reference on each golden scene.
#include <gtest/gtest.h>

#include "tests/golden/device_pictures.h"
#include "tests/golden/golden_files.h"
#include "tests/golden/golden_scenes.h"
#include "tests/reference/reference_renderer.h"

namespace mote::test {
namespace {

class DeviceGoldenTest : public testing::TestWithParam<std::tuple<std::string, GoldenScene>> {};

TEST_P(DeviceGoldenTest, MeetsTheReference) {
    const auto& [kind, golden] = GetParam();
    const auto device = deviceOf(kind);
    const auto scene = makeScene(golden.name);
    const auto reference = reference::render(scene, {golden.referenceSamples});
    const auto expected = reference::encode(reference);
    const auto actual = picture(*device, scene, render::Quality::exact());
    const auto result = compare(actual, expected, reference.ambiguous);
    RecordProperty("result", result.toString());
    const bool good = result.within(golden.limits);
    EXPECT_TRUE(good) << result.toString();
    if (good && !keepAll()) return;
    const auto name = golden.name + '-' + kind;
    keep(actual, name);
    keep(expected, golden.name + "-reference");
    if (result.sameShape) keep(difference(actual, expected), name + "-difference");
}

INSTANTIATE_TEST_SUITE_P(All, DeviceGoldenTest,
                         testing::Combine(testing::ValuesIn(deviceKinds()),
                                          testing::ValuesIn(goldenScenes())),
                         [](const auto& both) {
                             return std::get<0>(both.param) + '_' + std::get<1>(both.param).name;
                         });

INSTANTIATE_TEST_SUITE_P(Hybrids, DeviceGoldenTest,
                         testing::Combine(testing::ValuesIn(deviceKinds()),
                                          testing::ValuesIn(goldenHybrids())),
                         [](const auto& both) {
                             return std::get<0>(both.param) + '_' + std::get<1>(both.param).name;
                         });

INSTANTIATE_TEST_SUITE_P(Colors, DeviceGoldenTest,
                         testing::Combine(testing::ValuesIn(deviceKinds()),
                                          testing::ValuesIn(goldenColors())),
                         [](const auto& both) {
                             return std::get<0>(both.param) + '_' + std::get<1>(both.param).name;
                         });

}  // namespace
}  // namespace mote::test
