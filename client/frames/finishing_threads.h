// SPDX-License-Identifier: GPL-3.0-or-later
//
// FinishingThreads: a few threads that hand frames to a sink while the next ones are drawn. One owner; its
// `wake` is called by the threads.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "client/frames/frame_sink.h"

namespace mote::client {

class FinishingThreads {
  public:
    /// The sink outlives it. `wake`: something was finished.
    FinishingThreads(FrameSink& sink, unsigned threads, std::function<void()> wake);
    /// Waits for what is under way and drops the rest.
    ~FinishingThreads();
    FinishingThreads(const FinishingThreads&) = delete;
    FinishingThreads& operator=(const FinishingThreads&) = delete;

    void post(DrawnFrame frame);
    /// The frames that were finished since the last call. Errors: why the first frame of the film, among
    /// those under way, could not be; nothing is to be posted after it.
    Result<std::vector<std::size_t>> take();
    /// Frames that were posted and not taken.
    std::size_t open() const { return open_; }

  private:
    struct Finished {
        std::size_t index = 0;
        Status status = success();
    };

    void work();
    void end();

    FrameSink& sink_;
    const std::function<void()> wake_;
    std::size_t open_ = 0;  // the owner's

    std::mutex mutex_;
    std::condition_variable changed_;
    // Under the mutex.
    std::deque<DrawnFrame> waiting_;
    std::vector<Finished> finished_;
    bool ending_ = false;

    std::vector<std::thread> threads_;
};

}  // namespace mote::client
