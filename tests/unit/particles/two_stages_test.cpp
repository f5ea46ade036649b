// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/on_threads.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <latch>
#include <vector>

namespace mote::prep {
namespace {

Error failure() {
    return {ErrorCode::internal, "", "it failed"};
}

TEST(TwoStages, TakeTheItemsInTheirOrder) {
    std::vector<std::size_t> made, taken;
    const auto status = inTwoStages(
        100, 2,
        [&](std::size_t i) {
            made.push_back(i);
            return Result<std::size_t>(10 * i);
        },
        [&](std::size_t i, std::size_t value) {
            EXPECT_EQ(value, 10 * i);
            taken.push_back(i);
            return success();
        });
    EXPECT_TRUE(status.ok());
    ASSERT_EQ(taken.size(), 100U);
    EXPECT_TRUE(std::is_sorted(made.begin(), made.end()));
    EXPECT_TRUE(std::is_sorted(taken.begin(), taken.end()));
    EXPECT_TRUE(inTwoStages(
                    0, 2, [](std::size_t) { return Result<int>(failure()); },
                    [](std::size_t, int) { return Status(failure()); })
                    .ok());
}

TEST(TwoStages, TheNextIsMadeWhileOneIsTaken) {
    std::latch both(2);  // each stage waits for the other: they can only go on together
    const tbb::global_control two(tbb::global_control::max_allowed_parallelism, 2);  // also on one core
    tbb::task_arena arena(2);
    arena.execute([&] {
        const auto status = inTwoStages(
            2, 2,
            [&](std::size_t i) {
                if (i == 1) both.arrive_and_wait();
                return Result<int>(0);
            },
            [&](std::size_t i, int) {
                if (i == 0) both.arrive_and_wait();
                return success();
            });
        EXPECT_TRUE(status.ok());
    });
}

TEST(TwoStages, NoMoreAreUnderWayThanAllowed) {
    for (const std::size_t together : {1U, 2U}) {
        std::atomic<std::size_t> underWay{0}, most{0};
        const auto status = inTwoStages(
            200, together,
            [&](std::size_t) {
                most = std::max(most.load(), ++underWay);
                return Result<int>(0);
            },
            [&](std::size_t, int) {
                --underWay;
                return success();
            });
        EXPECT_TRUE(status.ok());
        EXPECT_LE(most, together);
    }
}

TEST(TwoStages, WhatWasUnderWayAtAnErrorIsNotTaken) {
    std::latch begun(1);
    std::vector<std::size_t> taken;
    const tbb::global_control two(tbb::global_control::max_allowed_parallelism, 2);  // also on one core
    tbb::task_arena arena(2);
    arena.execute([&] {
        const auto status = inTwoStages(
            3, 2,
            [&](std::size_t i) {
                if (i == 1) begun.count_down();
                return Result<int>(0);
            },
            [&](std::size_t i, int) -> Status {
                taken.push_back(i);
                begun.wait();
                return failure();
            });
        EXPECT_FALSE(status.ok());
    });
    EXPECT_EQ(taken, std::vector<std::size_t>{0});
}

TEST(TwoStages, TheFirstErrorEndsIt) {
    for (const bool inFirst : {true, false}) {
        std::vector<std::size_t> taken;
        std::size_t made = 0;
        const auto status = inTwoStages(
            100, 2,
            [&](std::size_t i) -> Result<int> {
                ++made;
                if (inFirst && i == 7) return failure();
                return 0;
            },
            [&](std::size_t i, int) -> Status {
                taken.push_back(i);
                if (!inFirst && i == 7) return failure();
                return success();
            });
        ASSERT_FALSE(status.ok());
        EXPECT_EQ(status.error().message, "it failed");
        EXPECT_EQ(taken.size(), inFirst ? 7U : 8U);
        EXPECT_LE(made, 9U) << "one more may have been under way";
    }
}

}  // namespace
}  // namespace mote::prep
