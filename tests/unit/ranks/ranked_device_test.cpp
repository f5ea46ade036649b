// SPDX-License-Identifier: GPL-3.0-or-later
//
// Pictures that several ranks draw against those of the cpu device alone, with ranks that are threads.
#include <gtest/gtest.h>

#include <new>

#include "server/render/cpu/composite/dark_cells.h"
#include "server/render/cpu/cpu_device.h"
#include "server/render/layers/make_frame_plan.h"
#include "storage/storage_error.h"
#include "tests/golden/comparison.h"
#include "tests/golden/golden_scenes.h"
#include "tests/golden/golden_strokes.h"
#include "tests/support/rank_crew.h"

namespace mote::test {
namespace {

using render::FramePlan;
using render::PixelFormat;

Image imageOf(const render::Picture& picture) {
    return {picture.width, picture.height, picture.pixels};
}

/// What differs from one rank's picture is the order in which a cell's weights and depths are added. Two
/// orders of n additions of numbers of one sign differ by at most n 2^-23 of their sum, so optical depths by
/// as much of themselves: as exp(-x) x is at most 0.37, and no cell here has 10^4 points, light by less than
/// 5e-4, of which a step of 8-bit sRGB in the darkest tone is 3e-4. One step up or down, in few pixels.
void expectSame(const render::Picture& actual, const render::Picture& expected) {
    const auto result = compare(imageOf(actual), imageOf(expected));
    EXPECT_TRUE(result.sameShape && result.sameAlpha);
    EXPECT_LE(result.worst, 1) << result.toString();
    EXPECT_EQ(actual.pointsDrawn, expected.pointsDrawn);
}

/// The same but that the cpu device alone places points in groups of leaves, which it counts whole
/// (PointGroups): one right at the border of a pixel may be in the next one, with its colour.
void expectSameOfLeaves(const render::Picture& leaves, const render::Picture& groups, std::uint64_t points) {
    constexpr Limits pointsAtBorders{.psnr = 80.0, .closeShare = 0.9999, .worst = 6};
    const auto result = compare(imageOf(leaves), imageOf(groups));
    EXPECT_TRUE(result.sameShape && result.sameAlpha);
    EXPECT_TRUE(result.worst <= 1 || result.within(pointsAtBorders)) << result.toString();
    EXPECT_LE(leaves.pointsDrawn, groups.pointsDrawn);
    EXPECT_LE(groups.pointsDrawn, points);
}

render::Picture draw(render::Device& device, const FramePlan& plan, PixelFormat format = PixelFormat::srgb8) {
    auto picture = device.render(plan, format, {});
    if (!picture) throw std::runtime_error("the picture was stopped");
    return *std::move(picture);
}

class RankedDeviceTest : public testing::TestWithParam<std::tuple<int, GoldenScene>> {};

TEST_P(RankedDeviceTest, DrawsThePictureOfOneRank) {
    const auto& [ranks, golden] = GetParam();
    const auto scene = makeScene(golden.name);
    RankCrew crew(ranks, scene), one(1, scene);
    render::CpuDevice alone;
    render::Quality few{.resolutionScale = 0.7, .pointFraction = 0.3, .slabs = 24, .samplesPerCell = 1.0};
    for (const auto& quality : {render::Quality::exact(), few}) {
        auto plan = makeFramePlan(scene, quality);
        plan.exact = true;  // else one rank may round the places of points
        std::uint64_t points = 0;
        for (const auto& layer : plan.points) points += layer.selection->points;
        const auto picture = draw(crew.device(), plan);
        expectSame(picture, draw(one.device(), plan));
        expectSameOfLeaves(picture, draw(alone, plan), points);
    }
}

INSTANTIATE_TEST_SUITE_P(Scenes, RankedDeviceTest,
                         testing::Combine(testing::Values(1, 2, 3), testing::ValuesIn(goldenScenes())),
                         [](const auto& both) {
                             return std::to_string(std::get<0>(both.param)) + '_' +
                                    std::get<1>(both.param).name;
                         });

INSTANTIATE_TEST_SUITE_P(Hybrids, RankedDeviceTest,
                         testing::Combine(testing::Values(2), testing::ValuesIn(goldenHybrids())),
                         [](const auto& both) {
                             return std::to_string(std::get<0>(both.param)) + '_' +
                                    std::get<1>(both.param).name;
                         });

INSTANTIATE_TEST_SUITE_P(Colors, RankedDeviceTest,
                         testing::Combine(testing::Values(2), testing::ValuesIn(goldenColors())),
                         [](const auto& both) {
                             return std::to_string(std::get<0>(both.param)) + '_' +
                                    std::get<1>(both.param).name;
                         });

/// A scene in which points and volume mix.
render::Scene mixedScene() {
    for (const auto& golden : goldenScenes()) {
        if (golden.volumeShare > 0.0 && golden.pointsShare > 0.0) return makeScene(golden.name);
    }
    throw std::runtime_error("no golden scene has points and volume");
}

TEST(RankedDevice, DrawsLargePicturesInBatchesAndOtherFormats) {
    auto scene = mixedScene();
    scene.view.width = 700;
    scene.view.height = 500;
    RankCrew crew(4, scene);
    render::CpuDevice alone;
    const auto plan = makeFramePlan(scene, render::Quality::exact());
    expectSame(draw(crew.device(), plan), draw(alone, plan));
    const auto half = draw(crew.device(), plan, PixelFormat::linearHalf);
    EXPECT_EQ(half.format, PixelFormat::linearHalf);
    EXPECT_EQ(half.pixels.size(), std::size_t{8} * plan.width * plan.height);
}

TEST(RankedDevice, EachRankCountsWhatItMakesOfFields) {
    const auto scene = makeScene("hybridResidual");
    RankCrew crew(3, scene);
    draw(crew.device(), makeFramePlan(scene, render::Quality::exact()));
    for (int rank = 0; rank < 3; ++rank)
        EXPECT_EQ(crew.steps(rank).memory->resident(), render::DarkCells::bytesOf(*scene.layers[0].hybrid));
}

TEST(RankedDevice, DrawsTheStrokesOfOneRank) {
    const auto scene = mixedScene();
    RankCrew crew(3, scene);
    render::CpuDevice alone;
    auto plan = makeFramePlan(scene, render::Quality::exact());
    const auto plain = draw(alone, plan);
    for (std::uint64_t seed = 1; seed <= 3; ++seed)
        addStrokes(plan, strokesFor(plan, seed), plan.nearDepth, plan.farDepth);
    expectSame(draw(crew.device(), plan), draw(alone, plan));
    EXPECT_NE(draw(alone, plan).pixels, plain.pixels);
}

TEST(RankedDevice, APictureThatGivesWayToOthersComesToTheSameBytes) {
    const auto small = mixedScene();
    auto scene = small;
    scene.view.width = 700;
    scene.view.height = 500;
    RankCrew crew(3, scene);
    auto plan = makeFramePlan(scene, render::Quality::exact());
    addStrokes(plan, strokesFor(plan, 1), plan.nearDepth, plan.farDepth);
    const auto between = makeFramePlan(small, render::Quality::exact());
    const auto expected = draw(crew.device(), plan), quick = draw(crew.device(), between);
    std::stop_source others;
    others.request_stop();
    for (const bool forgotten : {false, true, false}) {
        const auto large = crew.device().begin(plan, PixelFormat::srgb8, {});
        ASSERT_NE(large, nullptr);
        int turns = 1;
        for (; !large->advance(others.get_token()); ++turns) {
            EXPECT_GE(large->bytes(), expected.pixels.size());
            EXPECT_EQ(draw(crew.device(), between).pixels, quick.pixels);
            crew.device().trim();
            if (forgotten) break;
        }
        if (forgotten) continue;
        EXPECT_GT(turns, 1) << "it has several batches of tiles";
        const auto drawn = large->take();
        EXPECT_EQ(drawn.pixels, expected.pixels);
        EXPECT_EQ(drawn.pointsDrawn, expected.pointsDrawn);
    }
}

TEST(RankedDevice, AFailureWhileAPictureWaitsEndsItAlone) {
    auto scene = mixedScene();
    scene.view.width = 700;
    scene.view.height = 500;
    RankCrew crew(2, scene);
    const auto plan = makeFramePlan(scene, render::Quality::exact());
    const auto expected = draw(crew.device(), plan);
    std::stop_source others;
    others.request_stop();
    const auto large = crew.device().begin(plan, PixelFormat::srgb8, {});
    ASSERT_FALSE(large->advance(others.get_token()));
    crew.steps(1).broken = true;  // for pictures that are begun
    EXPECT_THROW(draw(crew.device(), plan), storage::StorageError);
    crew.steps(1).broken = false;
    while (!large->advance({})) {
    }
    EXPECT_EQ(large->take().pixels, expected.pixels);
}

TEST(RankedDevice, SaysHowManyRanksThereAre) {
    RankCrew crew(3, mixedScene());
    EXPECT_TRUE(crew.device().name().ends_with(" on 3 ranks")) << crew.device().name();
}

TEST(RankedDevice, AStopEndsAPictureOnAllRanks) {
    const auto scene = mixedScene();
    RankCrew crew(3, scene);
    const auto plan = makeFramePlan(scene, render::Quality::exact());
    std::stop_source stop;
    crew.steps(0).onName = [&] { stop.request_stop(); };  // before the order goes out
    EXPECT_FALSE(crew.device().render(plan, PixelFormat::srgb8, stop.get_token()));
    crew.steps(0).onName = {};
    render::CpuDevice alone;
    expectSame(draw(crew.device(), plan), draw(alone, plan));
}

TEST(RankedDevice, AFailureOnOneRankEndsThePictureAndNoMore) {
    const auto scene = mixedScene();
    RankCrew crew(3, scene);
    const auto plan = makeFramePlan(scene, render::Quality::exact());
    crew.steps(2).broken = true;  // read by the rank's thread after it had the order
    try {
        draw(crew.device(), plan);
        FAIL() << "a picture without the part of rank 2";
    } catch (const storage::StorageError& failure) {
        EXPECT_EQ(failure.error().code, ErrorCode::notFound);
        EXPECT_EQ(failure.error().toString(), "/data/beam.mote/step-000000.h5: rank 2: is not there");
    }
    crew.steps(2).broken = false;
    render::CpuDevice alone;
    expectSame(draw(crew.device(), plan), draw(alone, plan));
}

TEST(RankedDevice, ARankWithoutMemoryEndsThePictureAndNoMore) {
    const auto scene = mixedScene();
    RankCrew crew(3, scene);
    const auto plan = makeFramePlan(scene, render::Quality::exact());
    crew.steps(1).onBegin = [] { throw std::bad_alloc(); };
    try {
        draw(crew.device(), plan);
        FAIL() << "a picture without the part of rank 1";
    } catch (const storage::StorageError& failure) {
        EXPECT_EQ(failure.error().code, ErrorCode::resourceExhausted);
        EXPECT_EQ(failure.error().toString(), "view: rank 1: there is not enough memory to draw it");
    }
    crew.steps(1).onBegin = {};
    render::CpuDevice alone;
    expectSame(draw(crew.device(), plan), draw(alone, plan));
}

TEST(RankedDevice, NothingInViewIsBackground) {
    auto scene = mixedScene();
    scene.layers.clear();
    scene.view.layers.clear();
    RankCrew crew(2, scene);
    render::CpuDevice alone;
    const auto plan = makeFramePlan(scene, render::Quality::exact());
    EXPECT_EQ(draw(crew.device(), plan).pixels, draw(alone, plan).pixels);
}

}  // namespace
}  // namespace mote::test
