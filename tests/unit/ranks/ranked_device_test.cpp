// SPDX-License-Identifier: GPL-3.0-or-later
//
// Pictures that several ranks draw against those of the cpu device alone, with ranks that are threads.
#include <gtest/gtest.h>

#include <functional>
#include <thread>

#include "server/render/cpu/cpu_device.h"
#include "server/render/ranks/ranked_device.h"
#include "storage/storage_error.h"
#include "tests/golden/comparison.h"
#include "tests/golden/golden_scenes.h"
#include "tests/unit/ranks/thread_ranks.h"

namespace mote::test {
namespace {

using render::FramePlan;
using render::PixelFormat;

/// The steps of one scene, which all ranks have in memory.
class SceneSteps final : public render::RankSteps {
  public:
    explicit SceneSteps(const render::Scene& scene) : steps_(scene.steps), hybrids_(scene.hybrids) {}

    Result<Name> nameOf(const storage::ParticleStep& step) override {
        if (onName) onName();
        for (std::size_t i = 0; i < steps_.size(); ++i)
            if (steps_[i].get() == &step) return Name{std::to_string(i), "digest"};
        return Error{ErrorCode::unsupported, "", "no step of the scene"};
    }
    Result<std::shared_ptr<const storage::ParticleStep>> open(const Name& name) override {
        if (!broken) return steps_.at(std::stoul(name.file));
        return Error{ErrorCode::notFound, "/data/beam.mote/step-000000.h5", "is not there"};
    }

    Result<Name> nameOf(const render::HybridStep& step) override {
        for (std::size_t i = 0; i < hybrids_.size(); ++i)
            if (hybrids_[i].get() == &step) return Name{std::to_string(i), "digest"};
        return Error{ErrorCode::unsupported, "", "no step of the scene"};
    }
    Result<std::shared_ptr<const render::HybridStep>> openHybrid(const Name& name,
                                                                 HybridRepresentation) override {
        return hybrids_.at(std::stoul(name.file));
    }

    std::function<void()> onName;
    bool broken = false;

  private:
    std::vector<std::shared_ptr<const storage::ParticleStep>> steps_;
    std::vector<std::shared_ptr<const render::HybridStep>> hybrids_;
};

/// Ranks that serve while it lives.
class Crew {
  public:
    Crew(int size, const render::Scene& scene)
        : ranks_(size), steps_(static_cast<std::size_t>(size), SceneSteps(scene)) {
        for (int rank = 1; rank < size; ++rank) {
            threads_.emplace_back([this, rank] { render::serveRanks(ranks_[rank], steps(rank)); });
        }
        device_ = std::make_unique<render::RankedDevice>(ranks_[0], steps(0));
    }
    ~Crew() {
        render::dismissRanks(ranks_[0]);
        for (auto& thread : threads_) thread.join();
    }

    SceneSteps& steps(int rank) { return steps_[static_cast<std::size_t>(rank)]; }
    render::Device& device() { return *device_; }

  private:
    ThreadRanks ranks_;
    std::vector<SceneSteps> steps_;
    std::vector<std::thread> threads_;
    std::unique_ptr<render::Device> device_;
};

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

render::Picture draw(render::Device& device, const FramePlan& plan, PixelFormat format = PixelFormat::srgb8) {
    auto picture = device.render(plan, format, {});
    if (!picture) throw std::runtime_error("the picture was stopped");
    return *std::move(picture);
}

class RankedDeviceTest : public testing::TestWithParam<std::tuple<int, GoldenScene>> {};

TEST_P(RankedDeviceTest, DrawsThePictureOfOneRank) {
    const auto& [ranks, golden] = GetParam();
    const auto scene = makeScene(golden.name);
    Crew crew(ranks, scene);
    render::CpuDevice alone;
    render::Quality few{.resolutionScale = 0.7, .pointFraction = 0.3, .slabs = 24, .samplesPerCell = 1.0};
    for (const auto& quality : {render::Quality::exact(), few}) {
        auto plan = makeFramePlan(scene, quality);
        plan.exact = true;  // else one rank may round the places of points
        expectSame(draw(crew.device(), plan), draw(alone, plan));
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
    Crew crew(4, scene);
    render::CpuDevice alone;
    const auto plan = makeFramePlan(scene, render::Quality::exact());
    expectSame(draw(crew.device(), plan), draw(alone, plan));
    const auto half = draw(crew.device(), plan, PixelFormat::linearHalf);
    EXPECT_EQ(half.format, PixelFormat::linearHalf);
    EXPECT_EQ(half.pixels.size(), std::size_t{8} * plan.width * plan.height);
}

TEST(RankedDevice, SaysHowManyRanksThereAre) {
    Crew crew(3, mixedScene());
    EXPECT_TRUE(crew.device().name().ends_with(" on 3 ranks")) << crew.device().name();
}

TEST(RankedDevice, AStopEndsAPictureOnAllRanks) {
    const auto scene = mixedScene();
    Crew crew(3, scene);
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
    Crew crew(3, scene);
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

TEST(RankedDevice, NothingInViewIsBackground) {
    auto scene = mixedScene();
    scene.steps.clear();
    scene.view.layers.clear();
    Crew crew(2, scene);
    render::CpuDevice alone;
    const auto plan = makeFramePlan(scene, render::Quality::exact());
    EXPECT_EQ(draw(crew.device(), plan).pixels, draw(alone, plan).pixels);
}

}  // namespace
}  // namespace mote::test
