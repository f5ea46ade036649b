// SPDX-License-Identifier: GPL-3.0-or-later
//
// Steps under a budget: what comes into memory, what leaves it, and what is brought in ahead.
#include <gmock/gmock.h>

#include <atomic>
#include <condition_variable>
#include <fstream>
#include <mutex>
#include <thread>
#include <vector>

#include "server/data/step_cache.h"
#include "storage/hash.h"
#include "storage/manifest.h"
#include "storage/storage_error.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/storage/forged_digest.h"
#include "tests/unit/storage/tiny_dataset.h"

namespace mote::storage {
namespace {

using test::TinyDataset;
using testing::HasSubstr;

constexpr std::uint64_t mib = blockBytes;
constexpr std::uint64_t points = TinyDataset::points;
constexpr std::uint64_t firstBlock = mib / sizeof(PackedPosition);  ///< points that lie in the first MiB

/// Waits for what the loader's threads do.
class Arrivals {
  public:
    std::function<void()> notify() {
        return [this] {
            const std::lock_guard lock(mutex_);
            changed_.notify_all();
        };
    }
    void await(const std::function<bool()>& reached) {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, reached);
    }

  private:
    std::mutex mutex_;
    std::condition_variable changed_;
};

class StepMemory : public testing::Test {
  protected:
    StepMemory() { TinyDataset().write(dataset_); }

    void setBudget(std::uint64_t bytes) { budget_ = std::make_shared<BlockBudget>(bytes); }
    std::shared_ptr<const MappedStep> open() {
        auto opened = MappedStep::open(dataset_, *readManifest(dataset_), 0, budget_);
        EXPECT_TRUE(opened.ok()) << opened.error().toString();
        return *opened;
    }
    void startLoader(unsigned threads = 2) {
        loader_ = std::make_unique<server::StepLoader>(budget_, threads, arrivals_.notify());
    }
    void load(const std::shared_ptr<const MappedStep>& step, const StepNeed& need) {
        EXPECT_TRUE(loader_->want(step, need, server::StepLoader::Urgency::inUse));
        arrivals_.await([&] { return loader_->waiting() == 0; });
    }
    void flipByte(std::uint64_t offset) {
        std::fstream file(dataset_ / "step-000000.h5", std::ios::binary | std::ios::in | std::ios::out);
        file.seekg(static_cast<std::streamoff>(offset));
        const char before = static_cast<char>(file.get());
        file.seekp(static_cast<std::streamoff>(offset));
        file.put(static_cast<char>(before ^ 0x10));
    }
    std::uint64_t positionsOffset() { return test::digestOf(dataset_).arrays(11).offset(); }

    test::TempDir folder_;
    const std::filesystem::path dataset_ = folder_ / "tiny.mote";
    std::shared_ptr<BlockBudget> budget_;
    Arrivals arrivals_;
    std::unique_ptr<server::StepLoader> loader_;
};

TEST(BlockBudgetTest, RoomThatWasFoundIsTaken) {
    BlockBudget budget(mib);
    EXPECT_TRUE(budget.take(mib, budget.generation()));
    EXPECT_FALSE(budget.take(mib, budget.generation())) << "before anything came in";
    EXPECT_EQ(budget.resident(), mib);
    budget.giveBack(mib);
    EXPECT_TRUE(budget.take(mib, budget.generation()));
}

TEST(BlockBudgetTest, ThreadsNeverFindTheSameRoom) {
    BlockBudget budget(3 * mib);
    std::atomic<bool> beyond = false;
    std::atomic<int> served = 0;
    std::vector<std::thread> threads;
    for (int i = 0; i < 4; ++i) {
        threads.emplace_back([&] {
            for (int round = 0; round < 20000; ++round) {
                if (!budget.take(mib, budget.generation())) continue;
                if (budget.resident() > budget.limit()) beyond = true;
                ++served;
                budget.giveBack(mib);
            }
        });
    }
    for (auto& thread : threads) thread.join();
    EXPECT_FALSE(beyond);
    EXPECT_GT(served, 0);
    EXPECT_EQ(budget.resident(), 0U);
}

TEST_F(StepMemory, WithoutABudgetAllCountsAsReady) {
    const auto step = open();
    EXPECT_TRUE(step->octreeReady());
    EXPECT_TRUE(step->volumeReady());
    EXPECT_EQ(step->positionsReady(5, 100), 100U);
    EXPECT_EQ(step->previewReady(1000), 1000U);
}

TEST_F(StepMemory, WhatWasReadIsReadyAndCounts) {
    setBudget(100 * mib);
    const auto step = open();
    EXPECT_EQ(budget_->resident(), 0U);
    EXPECT_FALSE(step->octreeReady());
    EXPECT_FALSE(step->volumeReady());
    EXPECT_EQ(step->previewReady(1000), 0U);
    EXPECT_EQ(step->positionsReady(0, points), 0U);
    step->positions(0, 10);
    EXPECT_EQ(budget_->resident(), mib);
    EXPECT_EQ(step->positionsReady(0, points), firstBlock);
    EXPECT_EQ(step->positionsReady(7, points - 7), firstBlock - 7);
    EXPECT_EQ(step->positionsReady(7, 3), 3U);
    step->volume();
    step->nodes();
    step->preview(1000);
    EXPECT_TRUE(step->volumeReady());
    EXPECT_EQ(step->previewReady(1000), 1000U);
    EXPECT_FALSE(budget_->resident() == 0);
}

TEST_F(StepMemory, WhatWasUsedLongestAgoLeavesFirst) {
    setBudget(2 * mib);
    const auto step = open();
    step->positions(0, 1);
    budget_->beginGeneration();
    step->rows(0, 1);
    budget_->beginGeneration();
    step->positions(0, 1);  // again: the rows are older now
    budget_->beginGeneration();
    step->rows(mib / 8, 1);
    EXPECT_EQ(budget_->resident(), 2 * mib);
    EXPECT_EQ(step->positionsReady(0, points), firstBlock);
    EXPECT_EQ(step->rows(0, 1)[0], TinyDataset().row[0]);  // it comes back
}

TEST_F(StepMemory, OfEqualsTheTailOfTheFileLeavesFirst) {
    setBudget(2 * mib);
    const auto step = open();
    step->positions(0, points);  // two blocks, the second one shorter
    budget_->beginGeneration();
    step->rows(0, 1);
    EXPECT_EQ(step->positionsReady(0, points), firstBlock);
}

TEST_F(StepMemory, AClosedStepTakesNothing) {
    setBudget(100 * mib);
    auto step = open();
    step->rows(0, points);
    EXPECT_EQ(budget_->resident(), points * sizeof(std::uint64_t));
    step.reset();
    EXPECT_EQ(budget_->resident(), 0U);
}

TEST_F(StepMemory, ReadingThroughMoreThanThereIsRoomForKeepsTheBudget) {
    setBudget(2 * mib);
    const auto step = open();
    const auto rows = TinyDataset().row;
    for (std::uint64_t at = 0; at < points; at += 1000) {
        EXPECT_EQ(step->rows(at, 1)[0], rows[at]);
        EXPECT_LE(budget_->resident(), 2 * mib);
    }
}

TEST_F(StepMemory, MoreAtOnceThanTheBudgetIsAnErrorThatSaysWhatIsNeeded) {
    setBudget(2 * mib);
    const auto step = open();
    try {
        step->rows(0, points);
        FAIL();
    } catch (const StorageError& error) {
        EXPECT_EQ(error.error().code, ErrorCode::resourceExhausted);
        EXPECT_THAT(error.error().toString(), HasSubstr("/points/row: 2 MiB are needed at once"));
        EXPECT_THAT(error.error().message, HasSubstr("raise --memory"));
    }
}

TEST_F(StepMemory, AnOctreeBeyondTheBudgetIsSaidWhenTheStepIsOpened) {
    setBudget(100);
    const auto opened = MappedStep::open(dataset_, *readManifest(dataset_), 0, budget_);
    ASSERT_FALSE(opened.ok());
    EXPECT_EQ(opened.error().code, ErrorCode::resourceExhausted);
    EXPECT_THAT(opened.error().message, HasSubstr("raise --memory by"));
}

TEST_F(StepMemory, ABlockThatComesBackIsVerifiedAnew) {
    setBudget(mib);
    const auto step = open();
    step->positions(0, 1);
    budget_->beginGeneration();
    step->rows(0, 1);
    flipByte(positionsOffset() + 100);
    EXPECT_THROW(step->positions(0, 1), StorageError);
}

TEST_F(StepMemory, TheLoaderBringsInWhatIsNeeded) {
    setBudget(100 * mib);
    startLoader();
    const auto step = open();
    load(step, {.preview = 1000, .volume = true, .octree = true, .points = {{0, points}}});
    EXPECT_TRUE(step->octreeReady());
    EXPECT_TRUE(step->volumeReady());
    EXPECT_EQ(step->previewReady(1000), 1000U);
    EXPECT_EQ(step->positionsReady(0, points), points);
    EXPECT_NO_THROW(step->check());
    // Rows were not asked for.
    EXPECT_LT(budget_->resident(), points * sizeof(PackedPosition) + 2 * mib);
}

TEST_F(StepMemory, RangesComeInTheirOrderAndAreCut) {
    setBudget(mib);
    startLoader(1);
    const auto step = open();
    // There is room for one block of the two: the first that was named.
    load(step, {.points = {{points - 1, 1000000}, {0, 1}}});
    EXPECT_EQ(step->positionsReady(points - 1, 1), 1U);
    EXPECT_EQ(step->positionsReady(0, 1), 0U);
    load(step, {.points = {{points, 5}, {points + 10, 5}}});
    EXPECT_EQ(step->positionsReady(points - 1, 1), 1U);
}

TEST_F(StepMemory, WhatThePictureUsesIsNotGivenUpForMore) {
    setBudget(mib);
    startLoader();
    const auto step = open();
    budget_->beginGeneration();
    step->positions(0, 1);
    const StepNeed beyond{.points = {{firstBlock, 1000}}};
    load(step, beyond);
    EXPECT_FALSE(loader_->want(step, beyond, server::StepLoader::Urgency::inUse));
    EXPECT_TRUE(loader_->want(step, {.volume = true}, server::StepLoader::Urgency::inUse));
    EXPECT_TRUE(loader_->want(step, {}, server::StepLoader::Urgency::inUse));
    EXPECT_EQ(step->positionsReady(0, points), firstBlock);
    EXPECT_EQ(budget_->resident(), mib);
}

TEST_F(StepMemory, TheLatestNeedOfAStepCounts) {
    setBudget(100 * mib);
    const auto step = open();
    const auto other = open();
    // No thread has begun: the first needs are replaced before anything is done for them.
    startLoader(1);
    for (int i = 0; i < 10; ++i) {
        loader_->want(step, {.points = {{0, points}}}, server::StepLoader::Urgency::expected);
        loader_->want(step, {}, server::StepLoader::Urgency::expected);
    }
    load(other, {.volume = true});
    EXPECT_EQ(loader_->waiting(), 0U);
    EXPECT_TRUE(other->volumeReady());
    EXPECT_FALSE(step->volumeReady());
}

TEST_F(StepMemory, AStepThatIsGoneIsNotLoaded) {
    setBudget(100 * mib);
    startLoader(1);
    for (int i = 0; i < 20; ++i) {
        loader_->want(open(), {.octree = true, .points = {{0, points}}},
                      server::StepLoader::Urgency::expected);
    }
    const auto step = open();
    load(step, {.volume = true});
    EXPECT_TRUE(step->volumeReady());
    loader_.reset();
    EXPECT_LE(budget_->resident(), mib);  // of `step` alone
}

TEST_F(StepMemory, ADamagedBlockIsFoundAndSaid) {
    flipByte(positionsOffset() + mib + 5);
    setBudget(100 * mib);
    startLoader();
    const auto step = open();
    load(step, {.points = {{0, points}}});
    try {
        step->check();
        FAIL();
    } catch (const StorageError& error) {
        EXPECT_EQ(error.error().code, ErrorCode::corrupt);
        EXPECT_THAT(error.error().toString(), HasSubstr("/points/position: the block at byte 1048576"));
    }
}

TEST_F(StepMemory, AWrongOctreeIsSaidToWhoeverAsksForIt) {
    TinyDataset wrong;
    wrong.childCount = {2, 0, 1};
    const auto path = folder_ / "wrong.mote";
    wrong.write(path);
    setBudget(100 * mib);
    startLoader();
    const auto step = *MappedStep::open(path, *readManifest(path), 0, budget_);
    load(step, {.octree = true});
    EXPECT_TRUE(step->octreeReady());
    EXPECT_THROW(step->nodes(), StorageError);
}

}  // namespace
}  // namespace mote::storage
