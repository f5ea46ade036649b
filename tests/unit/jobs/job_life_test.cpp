// SPDX-License-Identifier: GPL-3.0-or-later
//
// A job's life as a value: each event in each stage, and lives at random.
#include "server/jobs/job_life.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <string>
#include <string_view>

namespace mote::server {
namespace {

using Stage = JobLife::Stage;

constexpr int kStages = static_cast<int>(Stage::cancelled) + 1;
constexpr int kEvents = static_cast<int>(JobEvent::roomless) + 1;

bool does(const JobStep& step, JobDeed deed) {
    return std::ranges::count(step.deeds, deed) > 0;
}

JobLife lifeAt(Stage stage) {
    JobLife life;
    life.stage = stage;
    life.attempts = 1;
    return life;
}

/// Where a dataset's job that was begun once is after an event: a letter a stage, in their order, a row an
/// event. w waits, p pauses, s starts, r runs, u unsure, o over, S succeeded, F failed, C cancelled.
constexpr std::string_view kLetters = "wpsruoSFC";
constexpr std::array<std::string_view, kEvents> kAfter{
    "spsruoSFC",  // chosen
    "wwwruoSFC",  // held
    "wwwruoSFC",  // denied
    "FFFruoSFC",  // refused
    "wprruoSFC",  // begun
    "wwsruoSFC",  // rested
    "CCCruoSFC",  // cancel
    "wpsrroSFC",  // found
    "wpsoooSFC",  // gone
    "wpsruoSFC",  // hidden
    "wpsruSSFC",  // made
    "wpsruFSFC",  // broken
    "wpsruwSFC",  // taken
    "wpsrupSFC",  // roomless
};

TEST(JobLife, EachEventInEachStage) {
    for (int event = 0; event < kEvents; ++event) {
        for (int stage = 0; stage < kStages; ++stage) {
            SCOPED_TRACE(testing::Message() << "event " << event << " in " << kLetters[stage]);
            const auto life = lifeAt(static_cast<Stage>(stage));
            const auto step = next(life, static_cast<JobEvent>(event), "why");
            const auto after = static_cast<std::size_t>(step.life.stage);
            EXPECT_EQ(kLetters[after], kAfter[event][stage]);
            EXPECT_EQ(step.error.empty(), step.life.stage != Stage::failed || life.stage == Stage::failed);
            EXPECT_EQ(does(step, JobDeed::clear), isLive(life.stage) && !isLive(step.life.stage));
            EXPECT_EQ(does(step, JobDeed::start),
                      life.stage == Stage::waits && step.life.stage == Stage::starts);
            EXPECT_EQ(does(step, JobDeed::go), life.stage == Stage::starts && step.life.stage == Stage::runs);
            const bool drops = static_cast<JobEvent>(event) == JobEvent::begun && !does(step, JobDeed::go);
            EXPECT_EQ(does(step, JobDeed::drop), drops);
        }
    }
}

TEST(JobLife, WhoseEndIsWantedEndsAtItsRunsEnd) {
    auto life = lifeAt(Stage::runs);
    auto step = next(life, JobEvent::cancel);
    EXPECT_TRUE(does(step, JobDeed::stop));
    EXPECT_FALSE(does(next(step.life, JobEvent::cancel), JobDeed::stop)) << "it was told";
    step = next(step.life, JobEvent::gone);
    for (const auto event : {JobEvent::broken, JobEvent::taken, JobEvent::roomless})
        EXPECT_EQ(next(step.life, event, "why").life.stage, Stage::cancelled);
    EXPECT_EQ(next(step.life, JobEvent::made).life.stage, Stage::succeeded) << "a dataset is published";
    step.life.keepsFiles = true;
    EXPECT_EQ(next(step.life, JobEvent::made).life.stage, Stage::cancelled) << "a film is its job's";
    life.stage = Stage::unsure;
    life.cancelled = true;
    EXPECT_TRUE(does(next(life, JobEvent::found), JobDeed::stop)) << "an earlier server was asked";
}

TEST(JobLife, WhatItHasMadeGoesWhereItStaysWithTheJob) {
    auto life = lifeAt(Stage::succeeded);
    EXPECT_EQ(next(life, JobEvent::cancel).life, life);
    life.keepsFiles = true;
    const auto step = next(life, JobEvent::cancel);
    EXPECT_EQ(step.life.stage, Stage::succeeded) << "it was made";
    EXPECT_TRUE(does(step, JobDeed::clear));
    EXPECT_EQ(next(step.life, JobEvent::cancel).life, step.life);
}

TEST(JobLife, InterruptionsAndFullDisksAreNotForEver) {
    auto life = lifeAt(Stage::over);
    auto step = next(life, JobEvent::taken, "a kill");
    EXPECT_EQ(step.life.interrupted, 1);
    step.life.attempts = 2;
    step.life.stage = Stage::over;
    EXPECT_EQ(next(step.life, JobEvent::taken, "a kill").error,
              "was interrupted twice (a kill): submit it again");
    for (int tried = 1; tried < mostRoomless; ++tried) {
        life.attempts = 1;
        life.stage = Stage::over;
        life = next(life, JobEvent::roomless, "no space left").life;
        EXPECT_EQ(life.stage, Stage::pauses);
        EXPECT_EQ(life.attempts, 0) << "it was none of its own";
    }
    life.stage = Stage::over;
    EXPECT_EQ(next(life, JobEvent::roomless, "no space left").error, "no space left (tried 12 times)");
}

/// What the next server knows of it.
JobLife afterRestart(JobLife life) {
    if (!isLive(life.stage)) return life;
    const bool running =
        life.stage == Stage::runs || life.stage == Stage::unsure || life.stage == Stage::over;
    life.stage = running ? Stage::unsure : Stage::waits;
    life.roomless = 0;
    return life;
}

/// Whatever happens in whatever order, and under whatever server: no run is begun beside another, nor more
/// often than that; what has ended stays so; and a client's wish and a run's end lead to an end.
TEST(JobLife, LivesAtRandom) {
    std::mt19937 random(7);
    for (int n = 0; n < 20'000; ++n) {
        JobLife life;
        life.keepsFiles = n % 2 == 0;
        life.mostAttempts = n % 3 == 0 ? 10 : 2;
        int begun = 0, roomless = 0;
        bool runs = false;
        for (int i = 0; i < 60; ++i) {
            const auto event = static_cast<JobEvent>(random() % kEvents);
            if (event == JobEvent::found && !runs) continue;
            if (random() % 16 == 0) life = afterRestart(life);
            const auto step = next(life, event, "why");
            if (event == JobEvent::gone) runs = false;
            if (does(step, JobDeed::rest)) ++roomless;
            if (does(step, JobDeed::go)) {
                ASSERT_FALSE(runs);
                runs = true;
                ++begun;
            }
            ASSERT_TRUE(!runs || takesPlace(step.life.stage));
            ASSERT_TRUE(isLive(life.stage) || !isLive(step.life.stage));
            life = step.life;
        }
        ASSERT_LE(begun, life.mostAttempts + roomless);
        for (const auto event : {JobEvent::cancel, JobEvent::gone, JobEvent::taken})
            life = next(life, event).life;
        ASSERT_FALSE(isLive(life.stage));
    }
}

}  // namespace
}  // namespace mote::server
