// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <map>

#include "tests/unit/frames/schedule_fixture.h"

namespace mote::server {
namespace {

using namespace std::chrono_literals;

TEST_F(RenderScheduleTest, ViewThatIsNotToBeDrawnYetWaitsWhileOthersAreDrawn) {
    ViewTask suspect;
    suspect.moving = true;
    suspect.arrived = now_;
    suspect.notBefore = now_ + 1s;
    ASSERT_TRUE(schedule_.setView(1, std::make_shared<const ViewTask>(std::move(suspect))).ok());
    EXPECT_FALSE(next());
    EXPECT_EQ(schedule_.nextDue(), now_ + 1s);
    view(2, true);
    const auto other = next();
    ASSERT_TRUE(other);
    EXPECT_EQ(other->session, 2u);
    schedule_.finishDrawn(*other, Stage::done);
    now_ += 1s;
    const auto job = next();
    ASSERT_TRUE(job);
    EXPECT_EQ(job->session, 1u);
}

TEST_F(RenderScheduleTest, RestingViewGoesThroughItsStagesAndSleeps) {
    EXPECT_FALSE(next());
    EXPECT_FALSE(schedule_.nextDue());
    view(1, false);
    auto job = next();
    ASSERT_TRUE(job);
    EXPECT_EQ(job->stage, Stage::quick);
    schedule_.finishDrawn(*job, Stage::intermediate);
    EXPECT_FALSE(next());  // it is not at rest yet
    EXPECT_EQ(schedule_.nextDue(), now_ + 40ms);
    now_ += 40ms;
    job = next();
    ASSERT_TRUE(job);
    EXPECT_EQ(job->stage, Stage::intermediate);
    schedule_.finishDrawn(*job, Stage::exact);
    EXPECT_FALSE(next());  // both credits are with the client
    EXPECT_FALSE(schedule_.nextDue());
    schedule_.addCredits(1, 2);
    job = next();
    ASSERT_TRUE(job);
    EXPECT_EQ(job->stage, Stage::exact);
    schedule_.finishDrawn(*job, Stage::done);
    EXPECT_FALSE(next());
    EXPECT_FALSE(schedule_.nextDue());
}

TEST_F(RenderScheduleTest, MovingViewSleepsAfterItsQuickPicture) {
    view(1, true);
    const auto job = next();
    schedule_.finishDrawn(*job, Stage::exact);
    now_ += 1h;
    EXPECT_FALSE(next());
    EXPECT_FALSE(schedule_.nextDue());
}

TEST_F(RenderScheduleTest, WhatWaitsForDataSleepsUntilSomeArrives) {
    view(1, true, true);
    schedule_.finishWaiting(*next());
    now_ += 1h;
    EXPECT_FALSE(next());
    EXPECT_FALSE(schedule_.nextDue());
    schedule_.dataArrived(now_);
    const auto job = next();
    ASSERT_TRUE(job);
    EXPECT_EQ(job->stage, Stage::exact);
    schedule_.finishDrawn(*job, Stage::done);
    schedule_.dataArrived(now_);
    EXPECT_FALSE(next()) << "it waited for nothing any more";
}

TEST_F(RenderScheduleTest, ANewViewDoesNotWaitForTheDataOfTheOneBefore) {
    view(1, true, true);
    schedule_.finishWaiting(*next());
    view(1, true);
    const auto job = next();
    ASSERT_TRUE(job);
    EXPECT_EQ(job->stage, Stage::quick);
    // Its credit came back: two pictures may be on their way.
    schedule_.finishDrawn(*job, Stage::exact);
    view(1, true);
    EXPECT_TRUE(next());
}

TEST_F(RenderScheduleTest, FinalOnlyStartsAtOnceWithTheExactPicture) {
    view(1, true, true);
    const auto job = next();
    ASSERT_TRUE(job);
    EXPECT_EQ(job->stage, Stage::exact);
}

TEST_F(RenderScheduleTest, SessionsTakeTurns) {
    std::vector<SessionId> order;
    view(1, true);
    view(2, true);
    for (int i = 0; i < 6; ++i) {
        const auto job = next();
        ASSERT_TRUE(job);
        order.push_back(job->session);
        schedule_.finishDrawn(*job, Stage::done);
        schedule_.addCredits(job->session, 1);
        view(job->session, true);
    }
    EXPECT_EQ(order, (std::vector<SessionId>{1, 2, 1, 2, 1, 2}));
}

TEST_F(RenderScheduleTest, QuickPicturesGoBeforeRefinementsAndStopThem) {
    view(1, false, true);
    const auto exact = next();
    ASSERT_TRUE(exact);
    view(2, true);
    EXPECT_TRUE(exact->stop.stop_requested());
    schedule_.finishStopped(*exact);
    const auto quick = next();
    ASSERT_TRUE(quick);
    EXPECT_EQ(quick->session, 2u);
    schedule_.finishDrawn(*quick, Stage::done);
    const auto again = next();
    ASSERT_TRUE(again);
    EXPECT_EQ(again->session, 1u);
    EXPECT_EQ(again->stage, Stage::exact);
    EXPECT_FALSE(again->stop.stop_requested());
}

TEST_F(RenderScheduleTest, SessionsTakeTurnsByTheTimeOfTheirPictures) {
    std::vector<SessionId> order;
    view(1, true);
    view(2, true);
    for (int i = 0; i < 8; ++i) {
        const auto job = next();
        ASSERT_TRUE(job);
        order.push_back(job->session);
        schedule_.charge(*job, job->session == 1 ? 30ms : 10ms);
        schedule_.finishDrawn(*job, Stage::done);
        schedule_.addCredits(job->session, 1);
        view(job->session, true);
    }
    EXPECT_EQ(order, (std::vector<SessionId>{1, 2, 2, 2, 1, 2, 2, 2}));
}

TEST_F(RenderScheduleTest, WhoWasIdleHasNoTimeToMakeUpFor) {
    schedule_.addCredits(1, 100);
    schedule_.addCredits(2, 100);
    for (int i = 0; i < 50; ++i) {
        view(1, true);
        const auto job = next();
        schedule_.charge(*job, 10ms);
        schedule_.finishDrawn(*job, Stage::done);
    }
    std::map<SessionId, int> turns;
    view(1, true);
    view(2, true);
    for (int i = 0; i < 20; ++i) {
        const auto job = next();
        ASSERT_TRUE(job);
        ++turns[job->session];
        schedule_.charge(*job, 10ms);
        schedule_.finishDrawn(*job, Stage::done);
        view(job->session, true);
    }
    EXPECT_GE(turns[1], 9);
}

TEST_F(RenderScheduleTest, RefinementThatWaitedTooLongTakesItsTurnAndGivesWay) {
    view(1, false, true);
    view(2, true);
    const auto quick = next();
    EXPECT_EQ(quick->session, 2u);
    schedule_.finishDrawn(*quick, Stage::done);
    now_ += 3s;
    schedule_.addCredits(2, 1);
    view(2, true);
    const auto exact = next();
    ASSERT_TRUE(exact);
    EXPECT_EQ(exact->session, 1u);  // served longest ago
    EXPECT_TRUE(exact->pause.stop_requested()) << "somebody waits for a quick picture already";
    EXPECT_FALSE(exact->stop.stop_requested()) << "or it would never be done";
    schedule_.finishStopped(*exact);
    EXPECT_EQ(next()->session, 2u);
}

TEST_F(RenderScheduleTest, RefinementIsPausedByAQuickPictureThatComesDuringItsTurn) {
    view(1, false, true);
    now_ += 3s;
    const auto exact = next();
    ASSERT_TRUE(exact);
    EXPECT_FALSE(exact->pause.stop_requested());
    view(2, true);
    EXPECT_TRUE(exact->pause.stop_requested());
    EXPECT_FALSE(exact->stop.stop_requested());
    view(1, false, true);
    EXPECT_TRUE(exact->stop.stop_requested()) << "nobody wants it any more";
}

TEST_F(RenderScheduleTest, ALargePictureIsDoneBesideAHandThatNeverRests) {
    // Ten milliseconds of each turn, of half a second in all; every quick picture takes twenty.
    schedule_.addCredits(2, 1000);
    view(1, false, true);
    view(2, true);
    int quick = 0, inARow = 0, mostInARow = 0;
    for (Clock::duration left = 500ms; left > 0ms; now_ += 20ms) {
        const auto job = next();
        ASSERT_TRUE(job);
        if (job->session == 2) {
            schedule_.charge(*job, 20ms);
            schedule_.finishDrawn(*job, Stage::done);
            view(2, true);
            inARow = 0;
            ASSERT_LT(++quick, 1000);
        } else {
            EXPECT_TRUE(job->pause.stop_requested());
            schedule_.charge(*job, 10ms);
            left -= 10ms;
            mostInARow = std::max(mostInARow, ++inARow);
            schedule_.finishStopped(*job);
        }
    }
    EXPECT_LE(mostInARow, 3) << "a hand waits for its share and no longer";
}

TEST_F(RenderScheduleTest, AViewThatMayNotBeDrawnYetStopsNobody) {
    ViewTask suspect;
    suspect.moving = true;
    suspect.arrived = now_;
    suspect.notBefore = now_ + 1s;
    view(1, false, true);
    const auto exact = next();
    ASSERT_TRUE(schedule_.setView(2, std::make_shared<const ViewTask>(std::move(suspect))).ok());
    EXPECT_FALSE(exact->stop.stop_requested());
}

TEST_F(RenderScheduleTest, RefinementsOfSeveralTakeTurnsByTheirTime) {
    // Half a second's work against four pictures of ten milliseconds each, which need not wait for its end.
    schedule_.addCredits(2, 10);
    view(1, false, true);
    auto large = next();
    ASSERT_TRUE(large);
    int small = 0;
    Clock::duration worked = 0ms;
    for (view(2, false, true); small < 4;) {
        EXPECT_TRUE(large->pause.stop_requested());
        EXPECT_FALSE(large->stop.stop_requested()) << "nothing of it is lost";
        schedule_.charge(*large, 10ms);
        worked += 10ms;
        schedule_.finishStopped(*large);
        for (large = next(); large && large->session == 2; large = next()) {
            EXPECT_TRUE(large->pause.stop_requested()) << "and it takes turns as well";
            schedule_.charge(*large, 10ms);
            schedule_.finishDrawn(*large, Stage::done);
            ++small;
            view(2, false, true);
        }
        ASSERT_TRUE(large);
    }
    EXPECT_LE(worked, 60ms);
}

TEST_F(RenderScheduleTest, QuickPictureWithoutACreditStopsNobody) {
    view(2, true);
    for (int i = 0; i < 2; ++i) {
        const auto job = next();
        schedule_.finishDrawn(*job, Stage::done);
        view(2, true);
    }
    view(1, false, true);
    const auto exact = next();
    ASSERT_TRUE(exact);
    EXPECT_EQ(exact->session, 1u);
    view(2, true);
    EXPECT_FALSE(exact->stop.stop_requested());
    schedule_.addCredits(2, 1);
    EXPECT_TRUE(exact->stop.stop_requested());
}

TEST_F(RenderScheduleTest, NewerViewStopsARefinementButNoQuickPicture) {
    view(1, true);
    const auto quick = next();
    view(1, false);
    EXPECT_FALSE(quick->stop.stop_requested());
    EXPECT_FALSE(schedule_.current(*quick));
    schedule_.finishDrawn(*quick, Stage::exact);
    const auto second = next();
    ASSERT_TRUE(second);
    EXPECT_EQ(second->stage, Stage::quick);  // of the newer view: the older one's next stage is forgotten
    schedule_.finishDrawn(*second, Stage::exact);
    schedule_.addCredits(1, 2);
    now_ += 1s;
    const auto exact = next();
    ASSERT_TRUE(exact);
    EXPECT_EQ(exact->stage, Stage::exact);
    view(1, true);
    EXPECT_TRUE(exact->stop.stop_requested());
}

TEST_F(RenderScheduleTest, FailedViewIsNotTriedAgainAndCostsNoCredit) {
    view(1, false);
    const auto job = next();
    schedule_.finishFailed(*job);
    now_ += 1h;
    EXPECT_FALSE(next());
    for (int i = 0; i < 2; ++i) {
        view(1, true);
        const auto drawn = next();
        ASSERT_TRUE(drawn);
        schedule_.finishDrawn(*drawn, Stage::done);
    }
}

TEST_F(RenderScheduleTest, ClosedSessionIsForgottenAndItsPictureStopped) {
    view(1, true);
    const auto job = next();
    schedule_.close(1);
    EXPECT_TRUE(job->stop.stop_requested());
    schedule_.finishStopped(*job);
    EXPECT_TRUE(schedule_.setView(1, task(true)).ok());
    schedule_.addCredits(1, 5);
    EXPECT_FALSE(next());
}

}  // namespace
}  // namespace mote::server
