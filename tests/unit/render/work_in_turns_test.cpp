// SPDX-License-Identifier: GPL-3.0-or-later
//
// Work that comes to a halt where its turn is over, at each giveWay() here.
#include "server/render/plan/work_in_turns.h"

#include <gtest/gtest.h>
#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <numeric>
#include <stdexcept>
#include <thread>
#include <vector>

#include "server/render/plan/in_turns.h"
#include "server/render/plan/long_list.h"

namespace mote::render {
namespace {

constexpr WorkInTurns::Duration none{0};

/// While it lives no thread begins: none finds a place for its stack.
class NoThreads {
  public:
    NoThreads() {
        pthread_attr_t vast;
        EXPECT_EQ(pthread_getattr_default_np(&before_), 0);
        EXPECT_EQ(pthread_getattr_default_np(&vast), 0);
        EXPECT_EQ(pthread_attr_setstacksize(&vast, std::size_t{1} << 60), 0);
        EXPECT_EQ(pthread_setattr_default_np(&vast), 0);
        pthread_attr_destroy(&vast);
    }
    ~NoThreads() {
        EXPECT_EQ(pthread_setattr_default_np(&before_), 0);
        pthread_attr_destroy(&before_);
    }
    NoThreads(const NoThreads&) = delete;
    NoThreads& operator=(const NoThreads&) = delete;

  private:
    pthread_attr_t before_;
};

class InTurns : public testing::Test {
  protected:
    InTurns() { others_.request_stop(); }
    /// How many turns the work took, with others before each but the first.
    int turnsOf(WorkInTurns& work, bool paused) {
        int turns = 1;
        while (!work.advance(paused ? others_.get_token() : std::stop_token())) ++turns;
        return turns;
    }

    std::stop_source others_;
};

TEST_F(InTurns, WorkHaltsWhereItGivesWay) {
    std::vector<int> done;
    const auto work = [&] {
        for (int i = 0; i < 5; ++i) {
            done.push_back(i);
            giveWay();
        }
    };
    WorkInTurns paused(work, none);
    for (std::size_t turn = 1; turn <= 5; ++turn) {
        EXPECT_FALSE(paused.advance(others_.get_token()));
        EXPECT_EQ(done.size(), turn) << "and nothing goes on meanwhile";
    }
    EXPECT_TRUE(paused.advance(others_.get_token()));
    done.clear();
    WorkInTurns alone(work, none);
    EXPECT_EQ(turnsOf(alone, false), 1);
    EXPECT_EQ(done.size(), 5u);
}

TEST_F(InTurns, LoopsGoOnWhereTheyWere) {
    for (const bool paused : {false, true}) {
        std::vector<std::atomic<int>> times(300), inRanges(1000);
        WorkInTurns work(
            [&] {
                forInTurns(std::size_t{0}, times.size(), [&](std::size_t i) { ++times[i]; });
                forRangesInTurns(inRanges.size(), 64, [&](const auto& range) {
                    for (auto i = range.begin(); i < range.end(); ++i) ++inRanges[i];
                });
            },
            none);
        const int turns = turnsOf(work, paused);
        EXPECT_TRUE(paused ? turns > 4 : turns == 1) << turns;
        for (const auto& once : times) EXPECT_EQ(once, 1);
        for (const auto& once : inRanges) EXPECT_EQ(once, 1);
    }
}

TEST_F(InTurns, PartsShareALoop) {
    for (const bool paused : {false, true}) {
        std::vector<int> times(300);
        std::vector<std::atomic<int>> inUse(3);
        WorkInTurns work(
            [&] {
                forPartsInTurns(inUse.size(), times.size(), {}, [&](std::size_t part, std::size_t i) {
                    EXPECT_EQ(inUse[part]++, 0);
                    ++times[i];
                    --inUse[part];
                });
            },
            none);
        const int turns = turnsOf(work, paused);
        EXPECT_TRUE(paused ? turns >= 100 : turns == 1) << turns;
        EXPECT_EQ(times, std::vector<int>(300, 1));
    }
    int count = 0;
    std::stop_source stop;
    forPartsInTurns(1, 300, stop.get_token(), [&](std::size_t, std::size_t) {
        if (++count == 5) stop.request_stop();
    });
    EXPECT_EQ(count, 5);
}

TEST_F(InTurns, ListsGrowInSteps) {
    constexpr std::size_t size = std::size_t{5} << 20;  // of 20 MiB
    std::vector<std::uint32_t> list;
    WorkInTurns work([&] { resizeInTurns(list, size); }, none);
    EXPECT_GT(turnsOf(work, true), 4);
    EXPECT_EQ(list.size(), size);
    EXPECT_EQ(std::count(list.begin(), list.end(), 0U), static_cast<std::ptrdiff_t>(size));
    resizeInTurns(list, 3);
    EXPECT_EQ(list.size(), 3U);
}

TEST_F(InTurns, AStepOfALoopDoesNotGiveWay) {
    std::atomic<int> begun = 0, ended = 0;
    WorkInTurns work(
        [&] {
            forInTurns(0, 50, [&](int) {
                ++begun;
                giveWay();
                ++ended;
            });
        },
        none);
    while (!work.advance(others_.get_token())) EXPECT_EQ(begun, ended);
    EXPECT_EQ(ended, 50);
}

TEST_F(InTurns, PartsOfRowsAreThePicture) {
    for (const std::uint32_t width : {1U, 511U, 512U, 1300U}) {
        std::vector<std::atomic<int>> pixels(std::size_t{width} * 3);
        std::vector<std::atomic<int>> parts(partsOfRows(width, 3));
        forPixelsInTurns(width, 3, [&](std::uint32_t row, std::uint32_t from, std::uint32_t to) {
            for (auto column = from; column < to; ++column) ++pixels[std::size_t{row} * width + column];
            ++parts[partOfRows(width, row, from)];
        });
        for (const auto& once : pixels) EXPECT_EQ(once, 1);
        for (const auto& once : parts) EXPECT_EQ(once, 1);
    }
}

TEST_F(InTurns, BothOfTwoGiveWay) {
    int one = 0, other = 0;
    const auto count = [](int& number) {
        for (int i = 0; i < 20; ++i) {
            ++number;
            giveWay();
        }
    };
    WorkInTurns work([&] { bothInTurns([&] { count(one); }, [&] { count(other); }); }, none);
    int seen = 0;
    while (!work.advance(others_.get_token())) {
        EXPECT_EQ(one + other, seen + std::min(2, 40 - seen)) << "a step each, and a halt of both";
        seen = one + other;
    }
    EXPECT_EQ(one + other, 40);
}

TEST_F(InTurns, WhatTheOwnerMustDoItsThreadDoes) {
    const auto owner = std::this_thread::get_id();
    int steps = 0;
    bool failed = false;
    WorkInTurns work(
        [&] {
            EXPECT_NE(std::this_thread::get_id(), owner);
            EXPECT_TRUE(byOwner(
                [&](const std::stop_token&) {
                    EXPECT_EQ(std::this_thread::get_id(), owner);
                    return ++steps == 3;
                },
                {}));
            try {
                byOwner([](const std::stop_token&) -> bool { throw std::runtime_error("lost"); }, {});
            } catch (const std::runtime_error&) {
                failed = true;
            }
        },
        none);
    EXPECT_EQ(turnsOf(work, false), 3);
    EXPECT_TRUE(failed);
    EXPECT_FALSE(byOwner([](const std::stop_token&) { return false; }, {})) << "here it is asked once";
}

TEST_F(InTurns, WhatItThrowsItsOwnerCatches) {
    WorkInTurns work(
        [] {
            bothInTurns([] { giveWay(); },
                        [] {
                            giveWay();
                            throw std::runtime_error("damaged");
                        });
        },
        none);
    EXPECT_FALSE(work.advance(others_.get_token()));
    EXPECT_THROW(work.advance({}), std::runtime_error);
}

TEST_F(InTurns, WorkThatNobodyWantsEndsWhereItIs) {
    struct Gone {
        bool& gone;
        ~Gone() { gone = true; }
    };
    bool gone = false, wentOn = false;
    {
        WorkInTurns work(
            [&] {
                const Gone here{gone};
                try {
                    bothInTurns([] { giveWay(); }, [] { giveWay(); });
                } catch (const std::exception&) {
                    wentOn = true;
                }
                wentOn = true;
            },
            none);
        EXPECT_FALSE(work.advance(others_.get_token()));
        EXPECT_FALSE(gone);
    }
    EXPECT_TRUE(gone);
    EXPECT_FALSE(wentOn);
    const WorkInTurns neverBegun([&] { wentOn = true; }, none);
    EXPECT_FALSE(wentOn);
}

TEST_F(InTurns, WhereThereAreNoThreadsAllIsDone) {
    int done = 0;
    WorkInTurns half([&] {
        const NoThreads noThreads;
        bothInTurns([&] { done += 1; }, [&] { done += 2; });
    });
    EXPECT_TRUE(half.advance({}));
    EXPECT_EQ(done, 3);
    const auto owner = std::this_thread::get_id();
    const NoThreads noThreads;
    WorkInTurns whole([&] {
        EXPECT_EQ(std::this_thread::get_id(), owner);
        giveWay();
        done = 7;
    });
    EXPECT_TRUE(whole.advance(others_.get_token()));
    EXPECT_EQ(done, 7);
}

TEST_F(InTurns, ATurnThatIsNotOverIsNotCutShort) {
    WorkInTurns work(
        [] {
            for (int i = 0; i < 100; ++i) giveWay();
        },
        std::chrono::hours(1));
    EXPECT_TRUE(work.advance(others_.get_token()));
}

}  // namespace
}  // namespace mote::render
