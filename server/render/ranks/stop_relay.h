// SPDX-License-Identifier: GPL-3.0-or-later
//
// StopRelay: carries a stop that is requested on rank 0 to the work of all ranks, while it lives. Meanwhile
// nobody else on this rank may call Ranks. Made and destroyed by the thread that draws.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>

#include "server/render/ranks/ranks.h"

namespace mote::render {

class StopRelay {
  public:
    /// `asked`: of rank 0; not looked at on the others.
    StopRelay(Ranks& ranks, std::uint64_t picture, std::stop_token asked);
    ~StopRelay();
    StopRelay(const StopRelay&) = delete;
    StopRelay& operator=(const StopRelay&) = delete;

    /// The token that stops the work.
    std::stop_token token() const { return source_.get_token(); }

  private:
    void send();
    void receive();

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
