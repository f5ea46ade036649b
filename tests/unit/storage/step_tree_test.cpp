// SPDX-License-Identifier: GPL-3.0-or-later
//
// Octree and leaves under a budget: what they count, when they go, and who still has them then.
#include <gmock/gmock.h>

#include <fstream>

#include "storage/blocks/block_budget.h"
#include "storage/manifest.h"
#include "storage/particles/mapped_step.h"
#include "storage/storage_error.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/storage/forged_digest.h"
#include "tests/unit/storage/tiny_dataset.h"

namespace mote::storage {
namespace {

using test::TinyDataset;

class StepTreeTest : public testing::Test {
  protected:
    StepTreeTest() { TinyDataset().write(dataset_); }

    std::shared_ptr<const MappedStep> open(std::uint64_t room) {
        budget_ = std::make_shared<BlockBudget>(room);
        return *MappedStep::open(dataset_, *readManifest(dataset_), 0, budget_);
    }
    /// What an octree takes, from the arrays of which it is.
    std::uint64_t treeBytes(const MappedStep& step) const {
        return step.bytesAtOnce() - TinyDataset().volume.size() * sizeof(float);
    }
    /// The tree is not used any more, and something else takes all of the room.
    void pushOut() {
        const auto generation = budget_->beginGeneration();
        ASSERT_TRUE(budget_->take(budget_->limit(), generation));
        budget_->giveBack(budget_->limit());
    }

    test::TempDir folder_;
    const std::filesystem::path dataset_ = folder_ / "tiny.mote";
    std::shared_ptr<BlockBudget> budget_;
};

TEST_F(StepTreeTest, ItCountsOnceAndTheMappedBlocksDoNot) {
    const auto step = open(1 << 20);
    step->nodes();
    step->leaves();
    EXPECT_EQ(budget_->resident(), treeBytes(*step));
    EXPECT_TRUE(step->octreeReady());
}

TEST_F(StepTreeTest, ItGoesForOthersAndComesBack) {
    const auto step = open(1 << 20);
    step->nodes();
    pushOut();
    EXPECT_FALSE(step->octreeReady());
    EXPECT_EQ(budget_->resident(), 0U);
    EXPECT_TRUE(std::ranges::equal(step->leaves().pointCount, TinyDataset().leafPointCount));
    EXPECT_EQ(budget_->resident(), treeBytes(*step));
}

TEST_F(StepTreeTest, WhoHoldsItKeepsItWhenItGoes) {
    auto step = open(1 << 20);
    const auto nodes = step->nodes();
    const auto leaves = step->leaves();
    pushOut();
    step.reset();
    EXPECT_TRUE(std::ranges::equal(nodes.firstChild, TinyDataset().firstChild));
    EXPECT_TRUE(std::ranges::equal(leaves.pointBegin, TinyDataset().leafPointBegin));
}

TEST_F(StepTreeTest, ItCountsUntilNobodyHoldsIt) {
    auto step = open(1 << 20);
    auto nodes = step->nodes();
    const auto bytes = treeBytes(*step);
    pushOut();
    EXPECT_EQ(budget_->resident(), bytes) << "it was given up, and is held";
    auto leaves = step->leaves();
    EXPECT_EQ(budget_->resident(), 2 * bytes) << "another copy";
    nodes = {};
    EXPECT_EQ(budget_->resident(), bytes);
    step.reset();
    EXPECT_EQ(budget_->resident(), bytes);
    leaves = {};
    EXPECT_EQ(budget_->resident(), 0U);
}

TEST_F(StepTreeTest, ItIsNotGivenUpWhileItIsUsed) {
    const auto step = open(1 << 20);
    const auto generation = budget_->beginGeneration();
    step->nodes();
    EXPECT_FALSE(budget_->take(budget_->limit(), generation));
    EXPECT_TRUE(step->octreeReady());
}

TEST_F(StepTreeTest, WithoutRoomItIsNotBroughtAhead) {
    const auto step = open(1 << 20);
    const auto generation = budget_->beginGeneration();
    ASSERT_TRUE(budget_->take(budget_->limit(), generation));
    EXPECT_FALSE(step->follow(MappedStep::Ahead::Follows::tree, generation));
    budget_->giveBack(budget_->limit());
    EXPECT_TRUE(step->follow(MappedStep::Ahead::Follows::tree, generation));
    EXPECT_TRUE(step->octreeReady());
}

TEST_F(StepTreeTest, WhatComesBackIsHeldToItsDigestAnew) {
    const auto step = open(1 << 20);
    step->nodes();
    pushOut();
    const auto digest = test::digestOf(dataset_);
    std::fstream file(dataset_ / "step-000000.h5", std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(static_cast<std::streamoff>(digest.arrays(static_cast<int>(StepArray::leafNode)).offset()));
    file.put('\x7f');
    file.close();
    try {
        step->leaves();
        FAIL() << "a leaf of node 127 was taken";
    } catch (const StorageError& error) {
        EXPECT_EQ(error.error().code, ErrorCode::corrupt);
        EXPECT_THAT(error.error().toString(), testing::HasSubstr("step-000000.h5:/leaves/node"));
    }
    EXPECT_EQ(budget_->resident(), 0U);
}

}  // namespace
}  // namespace mote::storage
