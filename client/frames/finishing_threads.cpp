// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/finishing_threads.h"

#include <algorithm>
#include <exception>
#include <utility>

namespace mote::client {

FinishingThreads::FinishingThreads(FrameSink& sink, unsigned threads, std::function<void()> wake)
    : sink_(sink), wake_(std::move(wake)) {
    for (unsigned i = 0; i < threads; ++i) threads_.emplace_back([this] { work(); });
}

FinishingThreads::~FinishingThreads() {
    end();
}

/// Waits for what is under way and drops the rest.
void FinishingThreads::end() {
    {
        const std::lock_guard lock(mutex_);
        ending_ = true;
        waiting_.clear();
    }
    changed_.notify_all();
    for (auto& thread : threads_) thread.join();
    threads_.clear();
}

void FinishingThreads::post(DrawnFrame frame) {
    ++open_;
    {
        const std::lock_guard lock(mutex_);
        waiting_.push_back(std::move(frame));
    }
    changed_.notify_one();
}

Result<std::vector<std::size_t>> FinishingThreads::take() {
    std::unique_lock lock(mutex_);
    const auto failed = [](const Finished& finished) { return !finished.status.ok(); };
    if (std::ranges::any_of(finished_, failed)) {
        // Threads fail in any order; who runs a script again hears the same.
        lock.unlock();
        end();
        std::erase_if(finished_, [&](const Finished& finished) { return !failed(finished); });
        return std::ranges::min_element(finished_, {}, &Finished::index)->status.error();
    }
    std::vector<std::size_t> frames;
    for (const auto& finished : finished_) frames.push_back(finished.index);
    finished_.clear();
    open_ -= frames.size();
    return frames;
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
