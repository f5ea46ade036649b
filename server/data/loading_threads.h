// SPDX-License-Identifier: GPL-3.0-or-later
//
// LoadingThreads: threads that bring data into memory, piece by piece, and give way to those that draw. Owned
// by whoever knows what the next piece is, as its last member: they end before what they use does.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace mote::server {

class LoadingThreads {
  public:
    /// `loadOne` loads a piece; it is false if there is none, and is not called then until wake(). It is
    /// called on all of the threads, of which there is at least one, and locks what it shares.
    LoadingThreads(unsigned threads, std::function<bool()> loadOne);
    ~LoadingThreads() { stop(); }
    LoadingThreads(const LoadingThreads&) = delete;
    LoadingThreads& operator=(const LoadingThreads&) = delete;

    /// There is something to load. Any thread.
    void wake();
    /// Ends them; waits for the pieces under way, not for others. Of the owner's thread.
    void stop();

  private:
    void run();

    const std::function<bool()> loadOne_;
    std::mutex mutex_;
    std::condition_variable wake_;
    // Under the mutex.
    std::uint64_t wakes_ = 0;
    bool stopping_ = false;

    std::vector<std::thread> threads_;
};

}  // namespace mote::server
