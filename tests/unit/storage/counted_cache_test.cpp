// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is kept of tables that are made of data: how many, what they count, and what goes for what.
#include "storage/blocks/counted_cache.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace mote::storage {
namespace {

using Table = std::string;

class CountedCacheTest : public testing::Test {
  protected:
    CountedCacheTest() { cache_.countTo(budget_); }

    std::shared_ptr<const Table> of(const std::shared_ptr<const int>& data, int key, std::size_t most = 4,
                                    std::uint64_t bytes = 10) {
        return cache_.of(data, key, most, bytes, [&] {
            ++made_;
            return std::to_string(*data) + " " + std::to_string(key);
        });
    }

    int made_ = 0;
    std::shared_ptr<BlockBudget> budget_ = std::make_shared<BlockBudget>(100);
    CountedCache<int, Table> cache_;
    const std::shared_ptr<const int> one_ = std::make_shared<int>(1), two_ = std::make_shared<int>(2);
};

TEST_F(CountedCacheTest, MakesEachTableOnce) {
    const auto first = of(one_, 7);
    EXPECT_EQ(*first, "1 7");
    EXPECT_EQ(*of(two_, 7), "2 7");
    EXPECT_EQ(*of(one_, 8), "1 8");
    EXPECT_EQ(of(one_, 7), first);
    EXPECT_EQ(made_, 3);
    EXPECT_EQ(budget_->resident(), 30U);
}

TEST_F(CountedCacheTest, BeyondItsNumberThatGoesWhichWasUsedLongestAgo) {
    for (const int key : {1, 2, 3}) of(one_, key, 3);
    of(one_, 1, 3);
    of(one_, 4, 3);
    EXPECT_EQ(budget_->resident(), 30U);
    EXPECT_EQ(made_, 4);
    for (const int key : {1, 3, 4}) of(one_, key, 3);
    EXPECT_EQ(made_, 4);
    of(one_, 2, 3);
    EXPECT_EQ(made_, 5);
    of(two_, 1, 1);
    EXPECT_EQ(budget_->resident(), 10U) << "one alone is kept";
    for (int key = 0; key < 100; ++key) of(one_, key, 1000);
    EXPECT_EQ(budget_->resident(), 10 * decltype(cache_)::mostKept);
}

TEST_F(CountedCacheTest, TablesOfEarlierPicturesGoForOtherData) {
    of(one_, 1);
    budget_->beginGeneration();
    of(one_, 2);
    EXPECT_TRUE(budget_->take(85, budget_->generation()));
    EXPECT_EQ(budget_->resident(), 95U);
    of(one_, 2);
    EXPECT_EQ(made_, 2) << "the present picture's stays";
    of(one_, 1);
    EXPECT_EQ(made_, 3);
    EXPECT_EQ(budget_->resident(), 105U) << "what a picture needs is counted even if there is no room";
    EXPECT_FALSE(budget_->take(1, budget_->generation()));
    budget_->giveBack(85);
}

TEST_F(CountedCacheTest, TablesMakeRoomForEachOther) {
    CountedCache<int, Table> other;
    other.countTo(budget_);
    other.of(one_, 1, 4, 60, [] { return Table("other"); });
    budget_->beginGeneration();
    of(one_, 1, 4, 60);
    EXPECT_EQ(budget_->resident(), 60U);
}

TEST_F(CountedCacheTest, WhatIsHeldBeyondItsTimeCountsUntilItIsLetGo) {
    auto held = of(one_, 1);
    budget_->beginGeneration();
    EXPECT_TRUE(budget_->take(95, budget_->generation())) << "passed over, as nobody can be asked for it";
    EXPECT_EQ(budget_->resident(), 105U);
    EXPECT_EQ(*held, "1 1");
    held.reset();
    EXPECT_EQ(budget_->resident(), 95U);
    budget_->giveBack(95);
}

TEST_F(CountedCacheTest, TablesGoWithTheirData) {
    auto data = std::make_shared<int>(3);
    of(data, 1);
    of(one_, 1);
    *data = 4;
    EXPECT_EQ(*of(data, 1), "3 1");
    data.reset();
    cache_.dropExpired();
    EXPECT_EQ(budget_->resident(), 10U);
}

/// Later data may stand where earlier ones stood.
TEST_F(CountedCacheTest, TellsDataAtOneAddressApart) {
    int place = 3;
    const auto data = [&] { return std::shared_ptr<const int>(&place, [](const int*) {}); };
    of(data(), 1);
    place = 4;
    EXPECT_EQ(*of(data(), 1), "4 1");
}

TEST_F(CountedCacheTest, WhatFailsCountsNothing) {
    const auto fail = []() -> Table { throw std::runtime_error("no"); };
    EXPECT_THROW(cache_.of(one_, 1, 4, 10, fail), std::runtime_error);
    EXPECT_EQ(budget_->resident(), 0U);
    EXPECT_EQ(*of(one_, 1), "1 1");
}

TEST_F(CountedCacheTest, CountsToOneBudgetOrNone) {
    of(one_, 1);
    const auto other = std::make_shared<BlockBudget>(100);
    cache_.countTo(other);
    EXPECT_EQ(budget_->resident(), 0U);
    of(one_, 1);
    EXPECT_EQ(other->resident(), 10U);
    EXPECT_TRUE(budget_->take(100, 2));
    EXPECT_FALSE(budget_->take(1, 2));
    EXPECT_EQ(*of(one_, 1), "1 1");
    EXPECT_EQ(made_, 2) << "the first budget asks nobody for room any more";
    cache_.countTo(nullptr);
    EXPECT_EQ(other->resident(), 0U);
    EXPECT_EQ(*of(one_, 1), "1 1");
    EXPECT_EQ(made_, 3);
    EXPECT_TRUE(other->take(100, 2));
}

TEST_F(CountedCacheTest, OthersMayTakeItsRoomAtAnyTime) {
    constexpr int pictures = 300, mostPictures = 1000 * pictures;
    std::atomic<bool> done{false};
    std::atomic<int> taken{0};  // times that there was room
    std::thread loader([&] {
        while (!done) {
            if (!budget_->take(60, budget_->generation())) continue;
            ++taken;
            budget_->giveBack(60);
        }
    });
    // However threads take turns, both have some.
    for (int i = 0; i < pictures || (taken < pictures && i < mostPictures); ++i) {
        budget_->beginGeneration();
        const auto first = of(one_, i % 3, 2, 30), second = of(two_, i % 5, 2, 30);
        EXPECT_EQ(*first, "1 " + std::to_string(i % 3));
        EXPECT_EQ(*second, "2 " + std::to_string(i % 5));
    }
    done = true;
    loader.join();
    cache_.countTo(nullptr);
    EXPECT_EQ(budget_->resident(), 0U);
    EXPECT_TRUE(budget_->take(100, budget_->generation()));
    EXPECT_FALSE(budget_->take(1, budget_->generation())) << "nothing is thought to be held any more";
}

}  // namespace
}  // namespace mote::storage
