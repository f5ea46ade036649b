// SPDX-License-Identifier: GPL-3.0-or-later
//
// What films need of the schedule: views in a queue, and sessions in the background.
#include <map>
#include <random>
#include <vector>

#include "protocol/wire/framing.h"
#include "tests/unit/frames/schedule_fixture.h"

namespace mote::server {
namespace {

using namespace std::chrono_literals;

TEST_F(RenderScheduleTest, QueuedViewsAreDrawnInTheirOrderAndOneTooManyIsRefused) {
    schedule_.addCredits(1, 100);
    for (std::uint64_t id = 0; id < wire::maxQueuedViews; ++id)
        ASSERT_TRUE(schedule_.setView(1, queuedTask(id)).ok()) << id;
    const auto refused = schedule_.setView(1, queuedTask(99));
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::resourceExhausted);
    for (std::uint64_t id = 0; id < wire::maxQueuedViews; ++id) {
        const auto job = next();
        ASSERT_TRUE(job);
        EXPECT_EQ(job->task->viewId, id);
        EXPECT_EQ(job->stage, Stage::exact);
        EXPECT_TRUE(schedule_.current(*job));
        // One that cannot be drawn holds up none of the others.
        if (id % 3 == 1) {
            schedule_.finishFailed(*job);
        } else {
            schedule_.finishDrawn(*job, Stage::done);
        }
        if (id == 0) {
            EXPECT_TRUE(schedule_.setView(1, queuedTask(wire::maxQueuedViews)).ok()) << "there is room again";
        }
    }
    EXPECT_EQ(next()->task->viewId, wire::maxQueuedViews);
}

TEST_F(RenderScheduleTest, AViewThatIsNotQueuedReplacesTheWholeQueue) {
    for (std::uint64_t id = 0; id < 3; ++id) ASSERT_TRUE(schedule_.setView(1, queuedTask(id)).ok());
    const auto job = next();
    view(1, true);
    EXPECT_TRUE(job->stop.stop_requested());
    schedule_.finishStopped(*job);
    const auto quick = next();
    ASSERT_TRUE(quick);
    EXPECT_EQ(quick->stage, Stage::quick);
    schedule_.finishDrawn(*quick, Stage::done);
    EXPECT_FALSE(next());
}

TEST_F(RenderScheduleTest, AQueuedViewWaitsForTheRefinementsOfTheOneBeforeIt) {
    schedule_.addCredits(1, 10);
    view(1, false);
    ASSERT_TRUE(schedule_.setView(1, queuedTask(7)).ok());
    const auto quick = next();
    EXPECT_EQ(quick->stage, Stage::quick);
    schedule_.finishDrawn(*quick, Stage::exact);
    now_ += 40ms;
    const auto exact = next();
    ASSERT_TRUE(exact);
    EXPECT_EQ(exact->task->viewId, 0u);
    schedule_.finishDrawn(*exact, Stage::done);
    EXPECT_EQ(next()->task->viewId, 7u);
}

TEST_F(RenderScheduleTest, ViewsThatStoodInTheirOwnQueueForLongAreNotUrgentForOthers) {
    schedule_.addCredits(1, 10);
    for (std::uint64_t id = 0; id < 3; ++id) ASSERT_TRUE(schedule_.setView(1, queuedTask(id)).ok());
    const auto first = next();
    now_ += 5s;
    schedule_.finishDrawn(*first, Stage::done);
    const auto second = next();
    ASSERT_TRUE(second);
    view(2, true);
    EXPECT_TRUE(second->stop.stop_requested()) << "it has waited for nobody but its own film";
}

class BackgroundTest : public RenderScheduleTest {
  protected:
    static constexpr SessionId film = 9;
    BackgroundTest() { schedule_.open(film, 100, true); }
};

TEST_F(BackgroundTest, AFilmIsDrawnAsFastAsItMayWhileNobodyElseWantsAPicture) {
    for (std::uint64_t id = 0; id < 5; ++id) ASSERT_TRUE(schedule_.setView(film, queuedTask(id)).ok());
    for (std::uint64_t id = 0; id < 5; ++id) {
        const auto job = next();
        ASSERT_TRUE(job);
        EXPECT_EQ(job->task->viewId, id);
        schedule_.finishDrawn(*job, Stage::done);
    }
}

TEST_F(BackgroundTest, WhateverOthersWantDrawnStopsItAndItWaitsUntilTheyAreQuiet) {
    for (const bool finalOnly : {false, true}) {
        ASSERT_TRUE(schedule_.setView(film, queuedTask(1)).ok());
        const auto stopped = next();
        ASSERT_TRUE(stopped);
        ASSERT_EQ(stopped->session, film);
        view(1, true, finalOnly);
        EXPECT_TRUE(stopped->stop.stop_requested());
        schedule_.finishStopped(*stopped);
        const auto other = next();
        ASSERT_TRUE(other);
        EXPECT_EQ(other->session, 1u);
        schedule_.finishDrawn(*other, Stage::done);
        EXPECT_FALSE(next()) << "another picture may be asked for at once";
        EXPECT_EQ(schedule_.nextDue(), now_ + 40ms);
        now_ += 40ms;
        const auto again = next();
        ASSERT_TRUE(again);
        EXPECT_EQ(again->session, film);
        schedule_.finishDrawn(*again, Stage::done);
    }
}

TEST_F(BackgroundTest, AHandThatWaitsForItsPicturesKeepsItWaiting) {
    RenderSchedule schedule({.handDelay = 1s});
    schedule.open(1, 100);
    schedule.open(film, 100, true);
    ASSERT_TRUE(schedule.setView(film, queuedTask(1)).ok());
    for (int i = 0; i < 5; ++i) {
        ASSERT_TRUE(schedule.setView(1, task(true)).ok());
        const auto quick = schedule.next(now_);
        ASSERT_TRUE(quick);
        schedule.finishDrawn(*quick, Stage::done);
        EXPECT_FALSE(schedule.next(now_));
        EXPECT_EQ(schedule.nextDue(), now_ + 1s);
        now_ += 300ms;  // that the client takes for it
        EXPECT_FALSE(schedule.next(now_));
    }
    ASSERT_TRUE(schedule.setView(1, task(false)).ok());
    schedule.finishDrawn(*schedule.next(now_), Stage::done);
    EXPECT_FALSE(schedule.next(now_));
    now_ += 40ms;
    const auto job = schedule.next(now_);
    ASSERT_TRUE(job) << "the hand has put it down";
    EXPECT_EQ(job->session, film);
}

TEST_F(BackgroundTest, ARefinementThatIsDueSoonKeepsItWaiting) {
    view(1, false);
    ASSERT_TRUE(schedule_.setView(film, queuedTask(1)).ok());
    const auto quick = next();
    schedule_.finishDrawn(*quick, Stage::exact);
    EXPECT_FALSE(next());
    EXPECT_EQ(schedule_.nextDue(), now_ + 40ms);
    now_ += 40ms;
    const auto exact = next();
    ASSERT_TRUE(exact);
    EXPECT_EQ(exact->session, 1u);
}

TEST_F(BackgroundTest, OthersThatHaveNoCreditOrWaitForDataKeepNobodyWaiting) {
    schedule_.open(3, 0);
    view(3, true);
    view(1, true, true);
    ASSERT_TRUE(schedule_.setView(film, queuedTask(1)).ok());
    schedule_.finishWaiting(*next());
    now_ += 40ms;
    EXPECT_FALSE(next()) << "they were busy until now";
    now_ += 40ms;
    const auto job = next();
    ASSERT_TRUE(job);
    EXPECT_EQ(job->session, film);
    schedule_.dataArrived(now_);
    EXPECT_TRUE(job->stop.stop_requested());
    schedule_.finishStopped(*job);
    EXPECT_EQ(next()->session, 1u);
}

TEST_F(BackgroundTest, NoWaitingMakesItUrgent) {
    ASSERT_TRUE(schedule_.setView(film, queuedTask(1)).ok());
    now_ += 1h;
    const auto job = next();
    ASSERT_TRUE(job);
    view(1, true);
    EXPECT_TRUE(job->stop.stop_requested());
    schedule_.finishStopped(*job);
    EXPECT_EQ(next()->session, 1u);
}

TEST_F(BackgroundTest, FilmsTakeTurnsAndDoNotStopEachOther) {
    schedule_.open(8, 100, true);
    std::vector<SessionId> order;
    for (std::uint64_t id = 0; id < 3; ++id) {
        for (const SessionId session : {SessionId{8}, film})
            ASSERT_TRUE(schedule_.setView(session, queuedTask(id)).ok());
    }
    for (int i = 0; i < 6; ++i) {
        const auto job = next();
        ASSERT_TRUE(job);
        order.push_back(job->session);
        schedule_.addCredits(8, 1);
        EXPECT_FALSE(job->stop.stop_requested());
        schedule_.finishDrawn(*job, Stage::done);
    }
    EXPECT_EQ(order, (std::vector<SessionId>{8, 9, 8, 9, 8, 9}));
}

/// Whatever happens, in whatever order: each queued view is drawn or fails once and in its order, and no film
/// is drawn while somebody else has a picture to be drawn.
TEST_F(BackgroundTest, RandomEventsBreakNoPromise) {
    std::mt19937 random(13);
    const auto chance = [&](unsigned of) { return random() % of == 0; };
    const std::vector<SessionId> films{1, film};  // one of them in the background
    std::map<SessionId, std::uint64_t> asked, answered;
    std::optional<RenderJob> job;
    bool handWants = false;  // session 2 has a picture to be drawn
    int drawn = 0, stopped = 0;
    for (int i = 0; i < 200'000; ++i) {
        now_ += std::chrono::milliseconds(random() % 20);
        for (const SessionId session : films) {
            if (!chance(4) || (session == 1 && i / 500 % 2 == 0)) continue;
            const auto waiting = asked[session] - answered[session];
            const bool taken = schedule_.setView(session, queuedTask(asked[session])).ok();
            ASSERT_EQ(taken, waiting < wire::maxQueuedViews);
            asked[session] += taken ? 1 : 0;
        }
        if (chance(30)) {
            view(2, true);
            handWants = true;
        }
        if (job && job->session == film && (handWants || asked[1] > answered[1])) {
            EXPECT_TRUE(job->stop.stop_requested());
        }
        if (!job) {
            job = next();
            if (job && job->session == film) {
                EXPECT_FALSE(handWants);
                EXPECT_EQ(asked[1], answered[1]);
            }
            continue;
        }
        if (!chance(2)) continue;
        const auto session = job->session;
        if (job->stop.stop_requested()) {
            schedule_.finishStopped(*job);
            ++stopped;
        } else if (session == 2) {
            handWants = !schedule_.current(*job);
            schedule_.finishDrawn(*job, Stage::done);
            schedule_.addCredits(2, 1);
        } else {
            EXPECT_EQ(job->task->viewId, answered[session]++);
            if (chance(10)) {
                schedule_.finishFailed(*job);
            } else {
                schedule_.finishDrawn(*job, Stage::done);
                schedule_.addCredits(session, 1);
            }
            ++drawn;
        }
        job.reset();
    }
    EXPECT_GT(drawn, 1000);
    EXPECT_GT(stopped, 100);
    EXPECT_GT(answered[film], 100u);
}

}  // namespace
}  // namespace mote::server
