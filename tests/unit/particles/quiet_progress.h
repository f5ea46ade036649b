// SPDX-License-Identifier: GPL-3.0-or-later
//
// QuietProgress: remembers what a job said; cancels after a given number of questions.
#pragma once

#include <atomic>
#include <mutex>
#include <string>
#include <vector>

#include "preprocess/job.h"

namespace mote::test {

class QuietProgress final : public prep::Progress {
  public:
    explicit QuietProgress(long cancelAfter = -1) : cancelAfter_(cancelAfter) {}

    void report(double fraction, std::string_view phase) override {
        const std::lock_guard lock(mutex_);
        fractions.push_back(fraction);
        phases.emplace_back(phase);
    }
    void note(std::string_view sentence) override {
        const std::lock_guard lock(mutex_);
        notes.emplace_back(sentence);
    }
    bool cancelled() const override {
        const long asked = asked_.fetch_add(1);
        return cancelAfter_ >= 0 && asked >= cancelAfter_;
    }
    /// How often cancelled() was asked.
    long asked() const { return asked_.load(); }

    std::vector<double> fractions;
    std::vector<std::string> phases;
    std::vector<std::string> notes;

  private:
    long cancelAfter_;
    mutable std::atomic<long> asked_{0};
    std::mutex mutex_;
};

}  // namespace mote::test
