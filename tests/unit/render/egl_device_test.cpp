// SPDX-License-Identifier: GPL-3.0-or-later
//
// The egl device's own ways: bands, passes, chunks, listed points, and what must not depend on them. That its
// pictures are right, tests/golden shows.
#include "server/render/egl/egl_device.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <thread>

#include "server/render/egl/resident_steps.h"
#include "server/render/layers/make_frame_plan.h"
#include "tests/reference/scene_styles.h"
#include "tests/support/beams.h"
#include "tests/support/memory_step.h"
#include "tests/support/view_text.h"

namespace mote::render {
namespace {

using test::MemoryStep;

std::shared_ptr<const MemoryStep> beamStep() {
    static const auto step =
        MemoryStep::make(test::beam({.core = 20000, .halo = 4000, .filaments = 2000}), {.leafCapacity = 32});
    return step;
}

Scene sceneOf(std::string_view layers, std::shared_ptr<const storage::ParticleStep> step = beamStep()) {
    Scene scene{test::viewOf("{'width': 173, 'height': 97, 'background': [0.1, 0.2, 0.3],"
                             "'camera': {'eye': [1, 0.7, 2.2], 'target': [0, 0, 0]}, 'layers': [" +
                             std::string(layers) + "]}"),
                {}};
    scene.layers.assign(scene.view.layers.size(), {.step = std::move(step)});
    return scene;
}

const char* const hybrid =
    "{'particles': {'volume': {'curve': [{'density': 0.2, 'opacity': 0},"
    "{'density': 1, 'opacity': 0.5}]}, 'points': {'opacity': 0.8}}}";
const char* const discs =
    "{'particles': {'volume': {'curve': [{'density': 0.2, 'opacity': 0},"
    "{'density': 1, 'opacity': 0.5}]}, 'points': {'opacity': 0.8, 'sizePixels': 4}}}";
const char* const pointsAlone =
    "{'particles': {'volume': {'curve': [{'density': 0, 'opacity': 0}]}, 'points': "
    "{'linked': false, 'opacity': 0.4, 'curve': [{'density': 0, 'fraction': 1}]}}}";

Picture drawn(EglDevice& device, const Scene& scene, const Quality& quality = Quality::exact()) {
    return device.render(makeFramePlan(scene, quality), PixelFormat::srgb8, {}).value();
}

std::size_t pixelsUnlike(const Picture& one, const Picture& other, int tolerance) {
    EXPECT_EQ(one.pixels.size(), other.pixels.size());
    std::size_t unlike = 0;
    for (std::size_t i = 0; i < one.pixels.size(); i += 4) {
        int most = 0;
        for (std::size_t c = i; c < i + 4; ++c)
            most = std::max(most, std::abs(one.pixels[c] - other.pixels[c]));
        unlike += most > tolerance;
    }
    return unlike;
}

TEST(EglDevice, ThePictureIsTheSameInBandsAndPasses) {
    for (const auto& layers : {std::string(hybrid), std::string(discs), std::string(pointsAlone),
                               std::string(hybrid) + ',' + pointsAlone}) {
        const auto scene = sceneOf(layers);
        EglDevice whole;
        const auto expected = drawn(whole, scene);
        EglOptions small;
        small.maskBytes = 1;  // a band holds one row of tiles at least
        small.cellBytes = 1;  // and a pass a few cells
        EglDevice pieces(small);
        EXPECT_EQ(drawn(pieces, scene).pixels, expected.pixels) << layers;
        EXPECT_EQ(pieces.lastTimes().bands, (scene.view.height + 7) / 8);
        EXPECT_EQ(whole.lastTimes().bands, 1U);
        EXPECT_EQ(whole.lastTimes().passes, 1U);
        if (layers == hybrid) {
            EXPECT_GT(pieces.lastTimes().passes, pieces.lastTimes().bands);
        }
    }
}

TEST(EglDevice, APictureThatGivesWayGoesOnFromItsNextBand) {
    const auto scene = sceneOf(std::string(hybrid) + ',' + pointsAlone);
    EglOptions small;
    small.maskBytes = 1;
    EglDevice device(small);
    const auto expected = drawn(device, scene);
    const auto plan = makeFramePlan(scene, Quality::exact());
    std::stop_source others;
    others.request_stop();
    const auto begun = device.begin(plan, PixelFormat::srgb8, {});
    std::uint32_t turns = 1;
    for (; !begun->advance(others.get_token()); ++turns) {
        EXPECT_EQ(device.lastTimes().bands, 1U);
        drawn(device, sceneOf(discs));
    }
    EXPECT_EQ(turns, (scene.view.height + 7) / 8);
    EXPECT_EQ(begun->take().pixels, expected.pixels);
    EXPECT_FALSE(device.begin(plan, PixelFormat::srgb8, others.get_token()));
}

TEST(EglDevice, PointsAloneNeedNoSlabs) {
    // The second layer's volume is too thin to be seen, but it forces the points into slabs.
    const auto flat = sceneOf(pointsAlone);
    auto slabs = sceneOf(pointsAlone);
    test::particlesIn(slabs).volumeOpacity = Curve::create({{0.0, 1e-9}}).value();
    EglDevice device;
    const auto expected = drawn(device, flat);
    EXPECT_EQ(device.lastTimes().cells, 0U);
    const auto actual = drawn(device, slabs);
    EXPECT_GT(device.lastTimes().cells, 0U);
    // A rounding apart, and the rays' rounding of exponentials: one step of 255 at most.
    EXPECT_EQ(pixelsUnlike(actual, expected, 1), 0U);
    EXPECT_GT(pixelsUnlike(actual, drawn(device, sceneOf(hybrid)), 1), 1000U);
}

TEST(EglDevice, ManySlabsTakeManyWords) {
    const auto scene = sceneOf(hybrid);
    EglDevice device;
    const auto exact = drawn(device, scene);
    for (const std::uint32_t slabs : {31U, 33U, 64U, 255U, 256U}) {
        Quality quality = Quality::exact();
        quality.slabs = slabs;
        // Coarse slabs mix what lies apart, so a few pixels differ; a slab in a wrong word would change most
        // of them.
        EXPECT_LT(pixelsUnlike(drawn(device, scene, quality), exact, 12), 300U) << slabs;
    }
}

TEST(EglDevice, FewPointsAreListedAndDrawnAlike) {
    // 45% of the points are listed, 55% are not; what both have drawn must agree but for the tenth in
    // between.
    EglDevice device;
    auto scene = sceneOf(pointsAlone);
    test::particlesIn(scene).pointFraction = Curve::constant(0.499);
    const auto listed = drawn(device, scene);
    test::particlesIn(scene).pointFraction = Curve::constant(0.501);
    const auto blocks = drawn(device, scene);
    const auto apart = blocks.pointsDrawn - listed.pointsDrawn;
    EXPECT_GT(listed.pointsDrawn, 5000U);
    EXPECT_GT(apart, 0U);
    EXPECT_LE(pixelsUnlike(listed, blocks, 0), apart);
}

/// Points that fill more than one chunk of the device's memory: 120 x 100 x 100 of them on a lattice.
std::shared_ptr<const MemoryStep> lattice() {
    std::vector<test::WeightedPoint> points;
    for (int i = 0; i < 120 * 100 * 100; ++i) {
        points.push_back({{(i % 120 + 0.5) / 120, (i / 120 % 100 + 0.5) / 100, (i / 12000 + 0.5) / 100}});
    }
    return MemoryStep::make(points, {.leafCapacity = 4000, .maxLevel = 4, .volumeLevel = 3});
}

TEST(EglDevice, MemoryIsGivenUpAndTakenAgain) {
    const auto step = lattice();
    ASSERT_GT(step->pointCount(), StepPoints::chunkPoints);
    const auto scene = sceneOf(pointsAlone, step);
    EglDevice roomy;
    const auto expected = drawn(roomy, scene);
    EXPECT_GT(expected.pointsDrawn, StepPoints::chunkPoints);
    EglOptions tight;
    tight.residentBytes = 1;
    EglDevice device(tight);
    for (int i = 0; i < 2; ++i) EXPECT_EQ(drawn(device, scene).pixels, expected.pixels);
}

TEST(EglDevice, KeepsNoStepAlive) {
    EglDevice device;
    auto step = MemoryStep::make(test::evenCloud(1000, 1));
    const std::weak_ptr<const MemoryStep> watched = step;
    drawn(device, sceneOf(pointsAlone, step));
    step.reset();
    EXPECT_TRUE(watched.expired());
    // A new step may take the old one's place in memory; it must not be taken for it.
    for (std::uint64_t seed = 2; seed < 6; ++seed) {
        const auto scene = sceneOf(pointsAlone, MemoryStep::make(test::evenCloud(1000, seed)));
        EglDevice fresh;
        EXPECT_EQ(drawn(device, scene).pixels, drawn(fresh, scene).pixels);
    }
    device.trim();
}

TEST(EglDevice, AnEmptyStepIsBackground) {
    EglDevice device;
    const auto scene = sceneOf(hybrid, MemoryStep::make({}));
    const auto result = drawn(device, scene);
    EXPECT_EQ(result.pointsDrawn, 0U);
    auto none = scene;
    none.view.layers.clear();
    none.layers.clear();
    EXPECT_EQ(result.pixels, drawn(device, none).pixels);
}

TEST(EglDevice, TwoOnTwoThreadsDrawAsOne) {
    const auto scene = sceneOf(hybrid);
    EglDevice here;
    const auto expected = drawn(here, scene);
    std::vector<std::uint8_t> there[2];
    std::vector<std::thread> threads;
    for (auto& pixels : there) {
        threads.emplace_back([&pixels, &scene] {
            EglDevice device;
            for (int i = 0; i < 3; ++i) pixels = drawn(device, scene).pixels;
        });
    }
    EXPECT_EQ(drawn(here, scene).pixels, expected.pixels);
    for (auto& thread : threads) thread.join();
    EXPECT_EQ(there[0], expected.pixels);
    EXPECT_EQ(there[1], expected.pixels);
}

TEST(EglDevice, StopsWhereverItIsAndGoesOnAfterwards) {
    const auto scene = sceneOf(hybrid);
    EglDevice device;
    const auto plan = makeFramePlan(scene, Quality::exact());
    std::stop_source stopped;
    stopped.request_stop();
    EXPECT_FALSE(device.render(plan, PixelFormat::srgb8, stopped.get_token()).has_value());
    // From another thread, at whatever moment it comes: no picture or the whole one, and never a wrong one
    // after it.
    const auto expected = drawn(device, scene);
    for (int i = 0; i < 8; ++i) {
        std::stop_source source;
        std::thread other([&source] { source.request_stop(); });
        const auto result = device.render(plan, PixelFormat::srgb8, source.get_token());
        other.join();
        EXPECT_TRUE(!result || result->pixels == expected.pixels);
        EXPECT_EQ(drawn(device, scene).pixels, expected.pixels);
    }
}

TEST(EglDevice, AShaderFolderWithoutShadersIsAnError) {
    EglOptions options;
    options.shaderDirectory = "no/such/folder";
    EglDevice device(options);
    EXPECT_THROW(drawn(device, sceneOf(hybrid)), DeviceError);
    // And its own sources, read from their folder, give the embedded ones' picture.
    options.shaderDirectory = MOTE_SHADER_FOLDER;
    EglDevice fromFolder(options), embedded;
    EXPECT_EQ(drawn(fromFolder, sceneOf(hybrid)).pixels, drawn(embedded, sceneOf(hybrid)).pixels);
}

}  // namespace
}  // namespace mote::render
