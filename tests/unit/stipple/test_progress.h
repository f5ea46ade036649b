// SPDX-License-Identifier: GPL-3.0-or-later
//
// TestProgress: remembers what a job reports, checks that it never falls, and can ask it to stop. A value of
// one test; any thread may report.
#pragma once

#include <gtest/gtest.h>

#include <mutex>

#include "preprocess/job.h"

namespace mote::test {

class TestProgress final : public prep::Progress {
  public:
    void report(double fraction, std::string_view) override {
        const std::lock_guard lock(mutex_);
        EXPECT_GE(fraction, 0.0);
        EXPECT_LE(fraction, 1.0);
        fraction_ = fraction;
    }
    void note(std::string_view) override {}
    bool cancelled() const override {
        const std::lock_guard lock(mutex_);
        return fraction_ >= limit_;
    }
    /// Asks to stop from that share of the work on.
    void cancelAt(double fraction) { limit_ = fraction; }

  private:
    mutable std::mutex mutex_;
    double fraction_ = 0.0;
    double limit_ = 2.0;
};

}  // namespace mote::test
