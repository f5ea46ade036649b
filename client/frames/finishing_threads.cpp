// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/finishing_threads.h"

#include <exception>
#include <utility>

namespace mote::client {

FinishingThreads::FinishingThreads(FrameSink& sink, unsigned threads, std::function<void()> wake)
    : sink_(sink), wake_(std::move(wake)) {
    for (unsigned i = 0; i < threads; ++i) threads_.emplace_back([this] { work(); });
}

FinishingThreads::~FinishingThreads() {
    {
        const std::lock_guard lock(mutex_);
        ending_ = true;
        waiting_.clear();
    }
    changed_.notify_all();
    for (auto& thread : threads_) thread.join();
}

void FinishingThreads::post(DrawnFrame frame) {
    ++open_;
    {
        const std::lock_guard lock(mutex_);
        waiting_.push_back(std::move(frame));
    }
    changed_.notify_one();
}

std::vector<FinishingThreads::Finished> FinishingThreads::take() {
    const std::lock_guard lock(mutex_);
    open_ -= finished_.size();
    return std::exchange(finished_, {});
}

void FinishingThreads::work() {
    std::unique_lock lock(mutex_);
    while (true) {
        changed_.wait(lock, [&] { return ending_ || !waiting_.empty(); });
        if (ending_) return;
        DrawnFrame frame = std::move(waiting_.front());
        waiting_.pop_front();
        lock.unlock();
        Finished finished{frame.index};
        try {
            finished.status = sink_.put(std::move(frame));
        } catch (const std::exception& failure) {
            finished.status = Error{ErrorCode::internal, "", failure.what()};
        }
        lock.lock();
        finished_.push_back(std::move(finished));
        wake_();
    }
}

}  // namespace mote::client
