// SPDX-License-Identifier: GPL-3.0-or-later
//
// FrameRun::Stage: notes how long a stage took, where EglOptions::measure asks for it.
#pragma once

#include <chrono>

#include "server/render/egl/frame_run.h"

namespace mote::render {

class FrameRun::Stage {
  public:
    Stage(const FrameRun& run, StageTimes::Duration& sum) : measure_(run.options_.measure), sum_(sum) {
        if (measure_) glFinish();
    }
    ~Stage() {
        if (!measure_) return;
        glFinish();
        sum_ += std::chrono::steady_clock::now() - start_;
    }
    Stage(const Stage&) = delete;
    Stage& operator=(const Stage&) = delete;

  private:
    bool measure_;
    StageTimes::Duration& sum_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace mote::render
