// SPDX-License-Identifier: GPL-3.0-or-later
//
// A schedule with two sessions, 1 and 2, of two credits each, and a clock that a test turns.
#pragma once

#include <gtest/gtest.h>

#include "server/frames/render_schedule.h"

namespace mote::server {

class RenderScheduleTest : public testing::Test {
  protected:
    RenderScheduleTest()
        : schedule_({.restDelay = std::chrono::milliseconds(40),
                     .patience = std::chrono::seconds(2),
                     .handDelay = std::chrono::seconds(0)}) {
        schedule_.open(1, 2);
        schedule_.open(2, 2);
    }

    std::shared_ptr<const ViewTask> queuedTask(std::uint64_t id) const {
        ViewTask made;
        made.viewId = id;
        made.finalOnly = made.queued = true;
        made.arrived = now_;
        return std::make_shared<const ViewTask>(std::move(made));
    }
    std::shared_ptr<const ViewTask> task(bool moving, bool finalOnly = false) const {
        ViewTask made;
        made.moving = moving;
        made.finalOnly = finalOnly;
        made.arrived = now_;
        return std::make_shared<const ViewTask>(std::move(made));
    }
    void view(SessionId session, bool moving, bool finalOnly = false) {
        EXPECT_TRUE(schedule_.setView(session, task(moving, finalOnly)).ok());
    }
    std::optional<RenderJob> next() { return schedule_.next(now_); }

    Clock::time_point now_{std::chrono::seconds(1000)};
    RenderSchedule schedule_;
};

}  // namespace mote::server
