// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/step_cache.h"

#include <gmock/gmock.h>

#include <condition_variable>
#include <filesystem>

#include "storage/blocks/mapped_file.h"
#include "storage/manifest.h"
#include "storage/storage_error.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/storage/tiny_dataset.h"

namespace mote::server {
namespace {

using test::TinyDataset;

constexpr std::uint64_t cacheMib = std::uint64_t{1} << 20;
constexpr std::uint32_t cachedSteps = 8;

class StepCacheTest : public testing::Test {
  protected:
    StepCacheTest() {
        storage::catchMappingFaults();
        TinyDataset().write(dataset_);
        // The same step again and again: a series that costs no room.
        auto manifest = *storage::readManifest(dataset_);
        auto& all = *manifest.mutable_particles()->mutable_steps();
        for (std::uint32_t i = 1; i < cachedSteps; ++i) *all.Add() = all[0];
        entry_ = {"data/tiny", dataset_, std::make_shared<const proto::Manifest>(std::move(manifest))};
    }

    void start(std::uint64_t bytes) {
        budget_ = std::make_shared<storage::BlockBudget>(bytes);
        cache_ = std::make_unique<StepCache>(budget_, 2, [this] {
            const std::lock_guard lock(mutex_);
            arrived_.notify_all();
        });
    }
    StepCache::Step step(std::uint32_t index) {
        auto opened = cache_->step(entry_, index);
        EXPECT_TRUE(opened.ok()) << opened.error().toString();
        return *opened;
    }
    void await(const std::function<bool()>& reached) {
        std::unique_lock lock(mutex_);
        arrived_.wait(lock, reached);
    }

    test::TempDir folder_;
    const std::filesystem::path dataset_ = folder_ / "tiny.mote";
    storage::Catalogue::Entry entry_;
    std::mutex mutex_;
    std::condition_variable arrived_;
    std::shared_ptr<storage::BlockBudget> budget_;
    std::unique_ptr<StepCache> cache_;
};

TEST_F(StepCacheTest, AStepIsOpenedOnce) {
    start(100 * cacheMib);
    EXPECT_EQ(step(0), step(0));
    EXPECT_NE(step(0), step(2));
    EXPECT_EQ(cache_->openSteps(), 2U);
}

TEST_F(StepCacheTest, WhatALiveDatasetGetsLeavesItsStepsOpen) {
    start(100 * cacheMib);
    auto manifest = *entry_.manifest;
    manifest.mutable_particles()->set_live(true);
    entry_.manifest = std::make_shared<const proto::Manifest>(manifest);
    const auto opened = step(0);
    auto& particles = *manifest.mutable_particles();
    *particles.add_steps() = particles.steps(0);
    entry_.manifest = std::make_shared<const proto::Manifest>(manifest);
    EXPECT_EQ(step(0), opened);
    EXPECT_EQ(step(cachedSteps)->pointCount(), opened->pointCount()) << "the new one";
    particles.set_density_max(2.0 * particles.density_max());
    entry_.manifest = std::make_shared<const proto::Manifest>(manifest);
    EXPECT_NE(step(0), opened) << "it looks otherwise now";
    particles.set_live(false);
    entry_.manifest = std::make_shared<const proto::Manifest>(manifest);
    const auto ended = step(0);
    entry_.manifest = std::make_shared<const proto::Manifest>(manifest);
    EXPECT_NE(step(0), ended) << "another dataset of this name";
}

TEST_F(StepCacheTest, WhatIsWantedArrives) {
    start(100 * cacheMib);
    const auto opened = step(0);
    const storage::StepNeed need{.volume = true, .octree = true};
    EXPECT_TRUE(cache_->want(*opened, need));
    await([&] { return opened->octreeReady() && opened->volumeReady(); });
    EXPECT_FALSE(cache_->want(*opened, need)) << "all is there";
}

TEST_F(StepCacheTest, StepsAreLoadedOnceTheyHoldWhatPicturesNeed) {
    start(100 * cacheMib);
    const auto first = step(0);
    EXPECT_TRUE(cache_->loaded(entry_).empty()) << "nobody has drawn anything";
    const storage::StepNeed need{.volume = true, .octree = true};
    EXPECT_TRUE(cache_->want(*first, need));
    await([&] { return !cache_->loaded(entry_).empty(); });
    EXPECT_EQ(cache_->loaded(entry_), std::vector<std::uint32_t>{0});
    const auto third = step(2);
    EXPECT_EQ(cache_->loaded(entry_), std::vector<std::uint32_t>{0}) << "it is open, and no more";
    EXPECT_TRUE(cache_->want(*third, need));
    await([&] { return cache_->loaded(entry_).size() == 2; });
    EXPECT_EQ(cache_->loaded(entry_), (std::vector<std::uint32_t>{0, 2}));
    // A picture that needs more makes them incomplete.
    EXPECT_TRUE(cache_->want(*third, {.octree = true, .points = {{0, TinyDataset::points}}}));
    await([&] { return third->positionsReady(0, TinyDataset::points) == TinyDataset::points; });
    EXPECT_EQ(cache_->loaded(entry_), std::vector<std::uint32_t>{2});
    auto other = entry_;
    other.manifest = std::make_shared<const proto::Manifest>(*entry_.manifest);
    EXPECT_TRUE(cache_->loaded(other).empty()) << "another dataset of this name";
}

TEST_F(StepCacheTest, WhatThereIsNoRoomForDoesNotCome) {
    start(cacheMib);
    const auto opened = step(0);
    const storage::StepNeed need{.points = {{0, TinyDataset::points}}};
    ASSERT_TRUE(cache_->want(*opened, need));
    await([&] { return !cache_->want(*opened, need); });
    EXPECT_LT(opened->positionsReady(0, TinyDataset::points), TinyDataset::points);
    EXPECT_LE(budget_->resident(), cacheMib);
}

TEST_F(StepCacheTest, TheNextStepsOfASeriesAreLoadedAheadAsFarAsTheOthersWere) {
    start(100 * cacheMib);
    const storage::StepNeed need{.volume = true, .points = {{0, 1000}}};
    cache_->want(*step(0), need);
    const auto shown = step(1);
    cache_->want(*shown, need);
    std::vector<StepCache::Step> next;
    // Each of them is open once it was loaded; asking for it then opens nothing.
    await([&] { return cache_->openSteps() >= 2 + stepsAhead; });
    const auto ahead = step(2);
    await([&] { return ahead->volumeReady() && ahead->positionsReady(0, 1000) == 1000; });
    EXPECT_FALSE(ahead->octreeReady()) << "nobody needed it";
}

TEST_F(StepCacheTest, AStepWhoseFileWasTruncatedIsOpenedAnewAndSaysWhatIsWrong) {
    start(100 * cacheMib);
    const auto opened = step(0);
    opened->positions(0, TinyDataset::points);
    std::filesystem::resize_file(dataset_ / "step-000000.h5", 5000);
    EXPECT_THROW(opened->check(), storage::StorageError);
    const auto again = cache_->step(entry_, 0);
    ASSERT_FALSE(again.ok());
    EXPECT_EQ(again.error().code, ErrorCode::corrupt);
    EXPECT_THAT(again.error().message, testing::HasSubstr("has 5000 bytes"));
}

TEST_F(StepCacheTest, StepsThatAreOpenTakeNoMoreThanTheirShare) {
    // Octree and volume of a step are some 500 bytes: the share has room for the latest and those ahead.
    start(2 * cacheMib);
    for (std::uint32_t i = 0; i < cachedSteps; i += 3) step(i);
    EXPECT_LE(cache_->openSteps(), std::size_t{cachedSteps});
    EXPECT_EQ(step(6)->pointCount(), TinyDataset::points);
}

}  // namespace
}  // namespace mote::server
