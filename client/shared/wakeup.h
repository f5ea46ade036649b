// SPDX-License-Identifier: GPL-3.0-or-later
//
// Wakeup: wakes the main thread when a server or a thread of ours has something for it. Any thread calls it;
// one waits.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>

namespace mote::client {

class Wakeup {
  public:
    void operator()() {
        {
            const std::lock_guard lock(mutex_);
            due_ = true;
        }
        changed_.notify_one();
    }

    /// Until it was called since the last wait, at most so long.
    void wait(std::chrono::milliseconds most) {
        std::unique_lock lock(mutex_);
        changed_.wait_for(lock, most, [&] { return due_; });
        due_ = false;
    }

  private:
    std::mutex mutex_;
    std::condition_variable changed_;
    bool due_ = false;
};

}  // namespace mote::client
