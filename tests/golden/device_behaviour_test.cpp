// SPDX-License-Identifier: GPL-3.0-or-later
//
// What each device must do beside meeting the reference: the same bytes again, light kept at lower quality,
// slabs that converge, pictures that can be stopped.
#include <gtest/gtest.h>

#include <algorithm>
#include <glm/common.hpp>
#include <glm/gtc/packing.hpp>
#include <stop_token>
#include <string>

#include "protocol/scene/srgb.h"
#include "tests/golden/comparison.h"
#include "tests/golden/device_pictures.h"
#include "tests/golden/golden_scenes.h"
#include "tests/reference/reference_renderer.h"
#include "tests/reference/scene_styles.h"

namespace mote::test {
namespace {

using render::Quality;

/// The number at `index` of a run of little-endian half floats.
double halfAt(const std::vector<std::uint8_t>& bytes, std::size_t index) {
    return glm::unpackHalf1x16(static_cast<std::uint16_t>(bytes[2 * index] | bytes[2 * index + 1] << 8));
}

class DeviceBehaviourTest : public testing::TestWithParam<std::string> {
  protected:
    std::unique_ptr<render::Device> device_ = deviceOf(GetParam());
};

TEST_P(DeviceBehaviourTest, SaysItsName) {
    EXPECT_EQ(device_->name().rfind(GetParam(), 0), 0U) << device_->name();
}

TEST_P(DeviceBehaviourTest, TheSameSceneGivesTheSameBytes) {
    const auto scene = makeScene("twoLayers");
    const auto first = picture(*device_, scene, Quality::exact());
    EXPECT_EQ(picture(*device_, scene, Quality::exact()), first);
    // Another scene in between, a memory that was freed and a new device leave no trace.
    EXPECT_NE(picture(*device_, makeScene("oddSize"), Quality::exact()), first);
    device_->trim();
    EXPECT_EQ(picture(*device_, scene, Quality::exact()), first);
    const auto again = deviceOf(GetParam());
    EXPECT_EQ(picture(*again, scene, Quality::exact()), first);
}

TEST_P(DeviceBehaviourTest, AStyleThatChangesIsSeen) {
    // A device keeps steps between pictures; nothing of a style may be kept with them.
    auto scene = makeScene("unlinked");
    const auto before = picture(*device_, scene, Quality::exact());
    particlesIn(scene).colorMap = ColorMap::find("magma").value();
    const auto recolored = picture(*device_, scene, Quality::exact());
    EXPECT_NE(recolored, before);
    particlesIn(scene).pointFraction = Curve::constant(0.0);
    EXPECT_NE(picture(*device_, scene, Quality::exact()), recolored);
}

TEST_P(DeviceBehaviourTest, FewerPointsKeepTheLight) {
    // A quarter of the points, each of which hides four times as much, leaves on average what all would
    // leave, however many share a pixel. The rest is the chance of sampling: some thousand points.
    auto scene = makeScene("haloOnly");
    particlesIn(scene).pointOpacity = 0.1;
    const double exact = meanLight(picture(*device_, scene, Quality::exact()));
    Quality quarter;
    quarter.pointFraction = 0.25;
    const double fewer = meanLight(picture(*device_, scene, quarter));
    ASSERT_GT(exact, 0.0);
    EXPECT_NEAR(fewer / exact, 1.0, 0.05);
}

TEST_P(DeviceBehaviourTest, HalfTheResolutionKeepsTheLight) {
    for (const char* name : {"unlinked", "discs", "zoomedInside"}) {
        const auto scene = makeScene(name);
        const auto exact = picture(*device_, scene, Quality::exact());
        Quality half;
        half.resolutionScale = 0.5;
        const auto smaller = picture(*device_, scene, half);
        EXPECT_EQ(smaller.width, exact.width / 2);
        EXPECT_EQ(smaller.height, exact.height / 2);
        // A point of one pixel becomes one of half a pixel that covers a quarter of a pixel four times as
        // large: the same light, but where points meet in a pixel they cover each other differently. A tenth
        // is allowed.
        EXPECT_NEAR(meanLight(smaller) / meanLight(exact), 1.0, 0.1) << name;
    }
}

TEST_P(DeviceBehaviourTest, MoreSlabsAreNeverWorse) {
    for (const char* name : {"unlinked", "denseCore"}) {
        const auto scene = makeScene(name);
        const auto expected = reference::encode(reference::render(scene));
        double before = 0.0, first = 0.0;
        for (const std::uint32_t slabs : {4U, 16U, 64U, 256U}) {
            Quality quality = Quality::exact();
            quality.slabs = slabs;
            // Above 55 dB a picture differs by the rounding of some pixels only, which slabs do not govern.
            const double psnr = std::min(compare(picture(*device_, scene, quality), expected).psnr, 55.0);
            EXPECT_GE(psnr, before) << name << ", " << slabs << " slabs";
            if (slabs == 4U) first = psnr;
            before = psnr;
            RecordProperty(name + std::to_string(slabs), std::to_string(psnr));
        }
        EXPECT_GT(before, first + 6.0) << name;
    }
}

TEST_P(DeviceBehaviourTest, AStoppedPictureIsEmpty) {
    std::stop_source source;
    source.request_stop();
    const auto plan = render::makeFramePlan(makeScene("twoLayers"), Quality::exact());
    EXPECT_FALSE(device_->render(plan, render::PixelFormat::srgb8, source.get_token()).has_value());
    // And the next one is whole again.
    EXPECT_TRUE(device_->render(plan, render::PixelFormat::srgb8, std::stop_token()).has_value());
}

TEST_P(DeviceBehaviourTest, APictureThatGivesWayToOthersComesToTheSameBytes) {
    std::stop_source others;
    others.request_stop();
    for (const char* name : {"twoLayers", "discs"}) {
        auto scene = makeScene(name);
        scene.view.width = 640;
        scene.view.height = 480;
        const auto plan = render::makeFramePlan(scene, Quality::exact());
        const auto expected = device_->render(plan, render::PixelFormat::srgb8, std::stop_token());
        ASSERT_TRUE(expected);
        const auto between = makeScene("oddSize");
        const auto quick = picture(*device_, between, Quality::exact());
        const auto large = device_->begin(plan, render::PixelFormat::srgb8, std::stop_token());
        ASSERT_NE(large, nullptr);
        int turns = 1;
        std::uint64_t bytes = expected->pixels.size();  // of the latest turn
        for (; !large->advance(others.get_token()); ++turns) {
            bytes = large->bytes();
            EXPECT_EQ(picture(*device_, between, Quality::exact()), quick) << name;
            device_->trim();
        }
        EXPECT_GE(bytes, expected->pixels.size());
        const auto drawn = large->take();
        EXPECT_EQ(drawn.pixels, expected->pixels) << name << " in " << turns << " turns";
        EXPECT_EQ(drawn.pointsDrawn, expected->pointsDrawn) << name;
        if (GetParam() == "cpu" && std::string(name) == "twoLayers") {
            EXPECT_GT(turns, 1) << "it has far more tiles than a turn must draw";
        }
    }
}

TEST_P(DeviceBehaviourTest, APictureThatGaveWayMayBeForgottenAndOutliveItsDevice) {
    std::stop_source others;
    others.request_stop();
    const auto plan = render::makeFramePlan(makeScene("twoLayers"), Quality::exact());
    const auto left = device_->begin(plan, render::PixelFormat::srgb8, std::stop_token());
    left->advance(others.get_token());
    device_ = nullptr;
}

TEST_P(DeviceBehaviourTest, APictureWithoutLayersIsItsBackground) {
    const View view{5, 3, 1.0, {1.0, 0.0, 0.25}, {}, {}, {}};
    const auto image = picture(*device_, {view, {}}, Quality::exact());
    ASSERT_EQ(image.pixels.size(), 60U);
    // 0.25 encodes to 137.
    for (std::size_t i = 0; i < 60; i += 4) {
        EXPECT_EQ((std::vector<int>(&image.pixels[i], &image.pixels[i] + 4)),
                  (std::vector<int>{255, 0, 137, 255}));
    }
}

TEST_P(DeviceBehaviourTest, HalfFloatsAreTheLinearPicture) {
    const auto scene = makeScene("unlinked");
    const auto expected = reference::render(scene);
    const auto result = device_->render(render::makeFramePlan(scene, Quality::exact()),
                                        render::PixelFormat::linearHalf, std::stop_token());
    ASSERT_TRUE(result);
    ASSERT_EQ(result->format, render::PixelFormat::linearHalf);
    ASSERT_EQ(result->pixels.size(), 8 * expected.linear.size());
    std::size_t close = 0;
    for (std::size_t i = 0; i < expected.linear.size(); ++i) {
        const glm::dvec3 color(halfAt(result->pixels, 4 * i), halfAt(result->pixels, 4 * i + 1),
                               halfAt(result->pixels, 4 * i + 2));
        ASSERT_EQ(halfAt(result->pixels, 4 * i + 3), 1.0);
        const glm::dvec3 off = glm::abs(linearToSrgb(color) - linearToSrgb(expected.linear[i]));
        if (std::max({off.x, off.y, off.z}) <= 2.5 / 255.0) ++close;
    }
    EXPECT_GE(static_cast<double>(close) / static_cast<double>(expected.linear.size()), 0.999);
}

INSTANTIATE_TEST_SUITE_P(All, DeviceBehaviourTest, testing::ValuesIn(deviceKinds()),
                         [](const auto& kind) { return kind.param; });

}  // namespace
}  // namespace mote::test
