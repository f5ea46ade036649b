// SPDX-License-Identifier: GPL-3.0-or-later
//
// StopRelay: how what is asked of rank 0 reaches work of all ranks that is under way. One a piece of work and
// rank.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>

#include "server/render/ranks/ranks.h"

namespace mote::render {

/// Carries a stop that is requested on rank 0 to the work of all ranks, while it lives. Meanwhile nobody else
/// on this rank may call Ranks.
class StopRelay {
  public:
    /// `asked`: of rank 0; not looked at on the others.
    StopRelay(Ranks& ranks, std::uint64_t picture, std::stop_token asked)
        : ranks_(ranks),
          picture_(picture),
          onAsked_(std::move(asked), [this] { source_.request_stop(); }),
          thread_([this] { ranks_.rank() == 0 ? send() : receive(); }) {}
    ~StopRelay() {
        {
            const std::lock_guard lock(mutex_);
            ended_ = true;
        }
        wake_.notify_all();
        thread_.join();
    }
    StopRelay(const StopRelay&) = delete;
    StopRelay& operator=(const StopRelay&) = delete;

    /// The token that stops the work.
    std::stop_token token() const { return source_.get_token(); }

  private:
    void send() {
        std::unique_lock lock(mutex_);
        if (!wake_.wait(lock, source_.get_token(), [this] { return ended_; })) ranks_.sendStop(picture_);
    }
    void receive() {
        std::unique_lock lock(mutex_);
        while (!wake_.wait_for(lock, std::chrono::milliseconds(1), [this] { return ended_; })) {
            if (ranks_.stopArrived(picture_)) {
                source_.request_stop();
                return;
            }
        }
    }

    Ranks& ranks_;
    const std::uint64_t picture_;
    std::stop_source source_;
    std::stop_callback<std::function<void()>> onAsked_;
    std::mutex mutex_;
    std::condition_variable_any wake_;
    bool ended_ = false;  // under the mutex
    std::thread thread_;
};

}  // namespace mote::render
