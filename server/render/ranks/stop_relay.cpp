// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ranks/stop_relay.h"

#include <chrono>
#include <utility>

namespace mote::render {

StopRelay::StopRelay(Ranks& ranks, std::uint64_t picture, std::stop_token asked)
    : ranks_(ranks),
      picture_(picture),
      onAsked_(std::move(asked), [this] { source_.request_stop(); }),
      thread_([this] { ranks_.rank() == 0 ? send() : receive(); }) {}

StopRelay::~StopRelay() {
    {
        const std::lock_guard lock(mutex_);
        ended_ = true;
    }
    wake_.notify_all();
    thread_.join();
}

void StopRelay::send() {
    std::unique_lock lock(mutex_);
    if (!wake_.wait(lock, source_.get_token(), [this] { return ended_; })) ranks_.sendStop(picture_);
}

void StopRelay::receive() {
    using namespace std::chrono_literals;
    std::unique_lock lock(mutex_);
    while (!wake_.wait_for(lock, 1ms, [this] { return ended_; })) {
        if (ranks_.stopArrived(picture_)) {
            source_.request_stop();
            return;
        }
    }
}

}  // namespace mote::render
