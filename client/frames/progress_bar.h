// SPDX-License-Identifier: GPL-3.0-or-later
//
// ProgressBar: how far a run is: on stderr where that is a terminal, and as lines of JobProgress on a
// descriptor for whoever runs it as a job. One thread.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>

namespace mote::client {

class ProgressBar {
  public:
    /// Shows nothing where `wanted` is false or stderr is no terminal; `descriptor` below 0: no lines.
    ProgressBar(bool wanted, int descriptor);
    ~ProgressBar();
    ProgressBar(const ProgressBar&) = delete;
    ProgressBar& operator=(const ProgressBar&) = delete;

    /// `done` of `total` frames, and what is done now.
    void show(std::size_t done, std::size_t total, std::string_view phase = "");

  private:
    void draw(std::size_t done, std::size_t total, std::string_view phase);
    void tell(std::size_t done, std::size_t total, std::string_view phase);

    const bool visible_;
    const int descriptor_;
    const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    std::chrono::steady_clock::time_point told_;
    std::size_t first_ = 0;  // frames that were done when it began
    bool shown_ = false;
};

}  // namespace mote::client
