// SPDX-License-Identifier: GPL-3.0-or-later
//
// RecordingProgress: remembers what a job reports, and asks it to stop at a chosen question. Any thread may
// ask; one reports.
#pragma once

#include <atomic>
#include <limits>
#include <string>
#include <vector>

#include "preprocess/job.h"

namespace mote::test {

class RecordingProgress : public prep::Progress {
  public:
    explicit RecordingProgress(int questions = std::numeric_limits<int>::max()) : left_(questions) {}

    void report(double fraction, std::string_view phase) override {
        fractions_.push_back(fraction);
        lastPhase_ = phase;
    }
    void note(std::string_view sentence) override { notes_.emplace_back(sentence); }
    /// True from the question after the first `questions`.
    bool cancelled() const override { return left_.fetch_sub(1) <= 0; }

    const std::vector<double>& fractions() const { return fractions_; }
    const std::vector<std::string>& notes() const { return notes_; }
    const std::string& lastPhase() const { return lastPhase_; }

  private:
    std::vector<double> fractions_;
    std::vector<std::string> notes_;
    std::string lastPhase_;
    mutable std::atomic<int> left_;
};

}  // namespace mote::test
