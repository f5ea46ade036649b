// SPDX-License-Identifier: GPL-3.0-or-later
//
// Steps of hybrid volumes under the budget: what is loaded when, in which order, and what goes for what.

#include <gmock/gmock.h>

#include <condition_variable>
#include <filesystem>

#include "server/data/load_hybrid.h"
#include "server/data/residency.h"
#include "server/render/layers/hybrid/hybrid_load.h"
#include "storage/hybrid/residual_file.h"
#include "storage/manifest.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/hybrid/small_hybrid.h"

namespace mote::server {
namespace {

using enum HybridRepresentation;
using testing::HasSubstr;

constexpr std::uint64_t hybridMib = std::uint64_t{1} << 20;
constexpr std::uint32_t steps = 16;

using Step = std::shared_ptr<const render::GridField>;

/// Its one thread waits after each step until the test lets it go on: what was loaded by then is certain.
class HybridResidency : public testing::Test {
  protected:
    HybridResidency() {
        test::writeSmallHybrid(dataset_, test::smallPoints(5), test::smallManifest(5, 8));
        auto manifest = *storage::readManifest(dataset_);
        // The same step again and again; its files are there once.
        auto& all = *manifest.mutable_hybrid()->mutable_steps();
        for (std::uint32_t i = 1; i < steps; ++i) *all.Add() = all[0];
        entry_ = {"data/small", dataset_, std::make_shared<const proto::Manifest>(std::move(manifest))};
        const auto& hybrid = entry_.manifest->hybrid();
        loading_ = render::hybridBytes(hybrid, 0, residual) + render::hybridLoadingBytes(hybrid, 0, residual);
    }
    ~HybridResidency() override {
        letGo(1000);
        residency_.reset();
    }

    void start(std::uint64_t bytes) {
        budget_ = std::make_shared<storage::BlockBudget>(bytes);
        residency_ = std::make_unique<Residency>(budget_, 1, [this] {
            std::unique_lock lock(mutex_);
            ++arrived_;
            changed_.notify_all();
            changed_.wait(lock, [this] { return arrived_ <= mayGo_; });
        });
    }
    void letGo(int more) {
        const std::lock_guard lock(mutex_);
        mayGo_ += more;
        changed_.notify_all();
    }
    void await(int arrivals) {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return arrived_ >= arrivals; });
    }
    /// Until nothing is under way.
    void awaitRest() {
        letGo(1000);
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [this] { return residency_->underWay() == 0; });
    }
    Step get(const Result<Loadable<render::GridField>>& what) {
        EXPECT_TRUE(what.ok()) << what.error().toString();
        const auto found = residency_->get(*what);
        EXPECT_TRUE(found.ok()) << found.error().toString();
        return found.ok() ? std::static_pointer_cast<const render::GridField>(found->value) : nullptr;
    }
    Step step(std::uint32_t index, HybridRepresentation representation = residual) {
        return get(hybridStep(entry_, index, representation));
    }
    Result<Resident> tried(std::uint32_t index) {
        return residency_->get(*hybridStep(entry_, index, residual));
    }
    /// What one takes in memory.
    std::uint64_t stepBytes() const {
        return (*render::loadHybrid(dataset_, *entry_.manifest, 0, residual))->bytes();
    }
    std::filesystem::path residualFile() const { return dataset_ / storage::residualName(0); }

    test::TempDir folder_;
    const std::filesystem::path dataset_ = folder_ / "small.mote";
    storage::Catalogue::Entry entry_;
    std::uint64_t loading_ = 0;  ///< that are counted while a step is loaded
    std::mutex mutex_;
    std::condition_variable changed_;
    int arrived_ = 0, mayGo_ = 0;
    std::shared_ptr<storage::BlockBudget> budget_;
    std::unique_ptr<Residency> residency_;
};

TEST_F(HybridResidency, NobodyWaitsForAStepThatIsLoaded) {
    start(100 * hybridMib);
    EXPECT_EQ(step(0), nullptr);
    await(1);
    const auto loaded = step(0);
    ASSERT_NE(loaded, nullptr);
    EXPECT_NE(loaded->bricks, nullptr);
    EXPECT_EQ(step(0), loaded);
    EXPECT_EQ(budget_->resident(), loaded->bytes());
}

TEST_F(HybridResidency, TheVolumeAloneComesFirst) {
    start(100 * hybridMib);
    step(9);
    await(1);
    EXPECT_EQ(step(0), nullptr);
    EXPECT_EQ(get(hybridVolume(entry_, 0)), nullptr);
    letGo(1);
    await(2);
    const auto low = get(hybridVolume(entry_, 0));
    ASSERT_NE(low, nullptr);
    EXPECT_EQ(low->bricks, nullptr);
    EXPECT_EQ(step(0), nullptr) << "still in line";
    awaitRest();
    EXPECT_NE(step(0), nullptr);
    EXPECT_EQ(get(hybridVolume(entry_, 0)), low);
}

TEST_F(HybridResidency, TheNextStepsOfASeriesAreLoadedInTheOrderInWhichTheyArePlayed) {
    start(100 * hybridMib);
    step(6);
    step(7);  // 6 may be loaded by now, or is still in line: nobody needs it any more
    letGo(1000);
    awaitRest();
    for (std::uint32_t i = 8; i < 8 + stepsAhead; ++i) {
        EXPECT_NE(step(i), nullptr) << i;
        awaitRest();
    }
}

TEST_F(HybridResidency, ASeriesIsPlayedOnceThereIsAnOrder) {
    start(100 * hybridMib);
    step(4);
    EXPECT_FALSE(residency_->played(entry_));
    step(5);
    EXPECT_TRUE(residency_->played(entry_));
    step(12);
    EXPECT_TRUE(residency_->played(entry_)) << "some were left out";
    step(9);
    EXPECT_FALSE(residency_->played(entry_));
}

TEST_F(HybridResidency, WhatIsExpectedComesOneAfterTheOther) {
    start(100 * hybridMib);
    step(2);
    await(1);
    step(3);
    letGo(1);
    await(2);
    letGo(1);
    await(3);  // 4
    EXPECT_EQ(residency_->loaded(), 3U);
    EXPECT_NE(step(4), nullptr);
    EXPECT_EQ(step(5), nullptr);
}

TEST_F(HybridResidency, WhatIsAskedForGoesBeforeWhatIsExpected) {
    start(100 * hybridMib);
    step(0);
    await(1);
    step(1);
    letGo(1);
    await(2);
    EXPECT_EQ(step(9), nullptr) << "a jump, while 2 to 5 are in line";
    letGo(1);
    await(3);
    EXPECT_NE(step(9), nullptr);
    EXPECT_EQ(residency_->loaded(), 3U);
}

TEST_F(HybridResidency, OfADatasetOnlyTheLatestIsWaitedFor) {
    start(100 * hybridMib);
    step(0);
    await(1);
    for (const std::uint32_t index : {3U, 9U, 14U, 6U}) step(index);
    letGo(1);
    await(2);
    EXPECT_NE(step(6), nullptr);
    awaitRest();
    EXPECT_EQ(residency_->loaded(), 2U) << "3, 9 and 14 were only passed";
}

TEST_F(HybridResidency, VolumesAndOtherBlocksMakeRoomForEachOther) {
    start(loading_);
    step(0);
    await(1);
    ASSERT_NE(step(0), nullptr);
    EXPECT_FALSE(budget_->take(loading_, budget_->generation())) << "the picture under way uses it";
    ASSERT_TRUE(budget_->take(loading_, budget_->beginGeneration()));
    EXPECT_EQ(residency_->loaded(), 0U);
    EXPECT_EQ(budget_->resident(), loading_);
    budget_->giveBack(loading_);
    EXPECT_EQ(step(0), nullptr) << "it is loaded anew";
}

TEST_F(HybridResidency, WhatThereIsNoRoomForIsSaid) {
    start(loading_ - 1);
    EXPECT_EQ(step(0), nullptr);
    letGo(1000);
    await(1);
    const auto refused = tried(0);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::resourceExhausted);
    EXPECT_EQ(budget_->resident(), 0U);
}

TEST_F(HybridResidency, AStepThatHadToGoBeforeItWasDrawnComesAtOnce) {
    start(loading_);
    EXPECT_EQ(step(0), nullptr);
    letGo(1000);
    await(1);
    ASSERT_TRUE(budget_->take(loading_, budget_->beginGeneration()));
    budget_->giveBack(loading_);
    EXPECT_NE(step(0), nullptr) << "or two of them could take turns for ever";
}

TEST_F(HybridResidency, WhatIsPlayedStaysForWhatComes) {
    const auto bytes = stepBytes();
    start(3 * bytes + loading_ - bytes);  // of three, while the third is loaded
    for (std::uint32_t i = 0; i < 2; ++i) {
        step(i);
        awaitRest();
    }
    for (std::uint32_t i = 1; i < steps; ++i) {
        budget_->beginGeneration();
        EXPECT_NE(step(i), nullptr) << i;
        awaitRest();
        EXPECT_LE(budget_->resident(), budget_->limit());
        EXPECT_LE(residency_->loaded(), 3U);
    }
}

TEST_F(HybridResidency, WhatIsWrongIsSaidWhenItIsAskedForAndTriedAnew) {
    start(100 * hybridMib);
    step(0);
    await(1);
    const auto kept = folder_ / "kept";
    std::filesystem::rename(residualFile(), kept);
    step(1);
    awaitRest();
    const auto missing = tried(1);
    ASSERT_FALSE(missing.ok());
    EXPECT_THAT(missing.error().where, HasSubstr("residual-000000.vdb"));
    std::filesystem::rename(kept, residualFile());
    // Steps 2 to 5 were expected, and failed: nobody is told.
    EXPECT_EQ(step(2), nullptr);
    awaitRest();
    EXPECT_NE(step(2), nullptr);
    EXPECT_EQ(step(1), nullptr);
    awaitRest();
    EXPECT_NE(step(1), nullptr);
}

TEST_F(HybridResidency, DatasetsOfOtherKindsAndRepresentationsAreRefused) {
    auto manifest = *entry_.manifest;
    manifest.mutable_hybrid()->set_residual(false);
    const storage::Catalogue::Entry bare{"data/bare", dataset_,
                                         std::make_shared<const proto::Manifest>(manifest)};
    EXPECT_EQ(hybridStep(bare, 0, residual).error().code, ErrorCode::unsupported);
    manifest.set_kind("particles");
    const storage::Catalogue::Entry other{"data/other", dataset_,
                                          std::make_shared<const proto::Manifest>(manifest)};
    EXPECT_EQ(hybridStep(other, 0, residual).error().code, ErrorCode::invalidArgument);
}

}  // namespace
}  // namespace mote::server
