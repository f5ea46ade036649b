// SPDX-License-Identifier: GPL-3.0-or-later
//
// ProgressBar: how far a run is, on stderr, where that is a terminal. Main thread.
#pragma once

#include <chrono>
#include <cstddef>

namespace mote::client {

class ProgressBar {
  public:
    /// Shows nothing where `wanted` is false or stderr is no terminal.
    ProgressBar(std::size_t total, bool wanted);
    ~ProgressBar();  ///< wipes its line
    ProgressBar(const ProgressBar&) = delete;
    ProgressBar& operator=(const ProgressBar&) = delete;

    void show(std::size_t done);

  private:
    const std::size_t total_;
    const bool visible_;
    const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace mote::client
