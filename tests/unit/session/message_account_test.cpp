// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/session/message_account.h"

#include <gtest/gtest.h>

#include <deque>
#include <optional>

namespace mote::server {
namespace {

constexpr std::size_t MiB = 1 << 20;

TEST(MessageAccount, WhatIsHeldLeavesLessRoom) {
    MessageAccount account(2 * MiB, nullptr);
    EXPECT_TRUE(account.roomFor(2 * MiB));
    EXPECT_FALSE(account.roomFor(2 * MiB + 1));
    auto first = std::optional(account.hold(MiB));
    EXPECT_TRUE(account.room());
    EXPECT_TRUE(account.roomFor(MiB));
    EXPECT_FALSE(account.roomFor(MiB + 1));
    // One that is there counts, though it is one too many.
    const auto large = account.hold(3 * MiB);
    EXPECT_FALSE(account.room());
    EXPECT_FALSE(account.roomFor(1));
    first.reset();
    EXPECT_EQ(account.held(), 3 * MiB);
    EXPECT_FALSE(account.room());
}

TEST(MessageAccount, AHoldThatMovesIsCountedOnce) {
    MessageAccount account(MiB, nullptr);
    std::deque<MessageAccount::Hold> waiting;
    for (int i = 0; i < 3; ++i) waiting.push_back(account.hold(100));
    auto taken = std::move(waiting.front());
    waiting.pop_front();
    EXPECT_EQ(account.held(), 300U);
    taken = std::move(waiting.front());  // gives back what it was
    waiting.pop_front();
    EXPECT_EQ(account.held(), 200U);
    waiting.clear();
    taken = {};
    EXPECT_EQ(account.held(), 0U);
}

TEST(MessageAccount, LargeOnesArePartOfTheMemoryForData) {
    const auto budget = std::make_shared<storage::BlockBudget>(16 * MiB);
    auto account = std::make_optional<MessageAccount>(MiB, budget);
    auto large = account->hold(MiB);
    const auto small = account->hold(1000);
    EXPECT_EQ(budget->resident(), MiB);
    // Whoever holds it may outlive the account.
    account.reset();
    large = {};
    EXPECT_EQ(budget->resident(), 0U);
}

}  // namespace
}  // namespace mote::server
