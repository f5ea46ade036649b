// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/frames/encode_pool.h"

#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

namespace mote::server {

struct EncodePool::Impl {
    std::mutex mutex;
    std::condition_variable wake;
    std::map<SessionId, std::deque<std::function<void()>>> waiting;  // of sessions with work, at least one
    std::deque<SessionId> ready;  // sessions with work that no thread is on
    bool stopping = false;
    std::vector<std::thread> threads;

    void work() {
        std::unique_lock lock(mutex);
        for (;;) {
            wake.wait(lock, [this] { return stopping || !ready.empty(); });
            if (stopping) return;
            const SessionId session = ready.front();
            ready.pop_front();
            auto task = std::move(waiting[session].front());
            lock.unlock();
            task();
            task = nullptr;  // its picture goes before we wait
            lock.lock();
            finished(session);
        }
    }

    /// A session stays in `waiting` while a thread is on it, so that nobody else takes its next piece.
    void finished(SessionId session) {
        auto& queue = waiting[session];
        queue.pop_front();
        if (queue.empty()) {
            waiting.erase(session);
        } else {
            ready.push_back(session);
            wake.notify_one();
        }
    }
};

EncodePool::EncodePool(unsigned threads) : impl_(std::make_unique<Impl>()) {
    for (unsigned i = 0; i < threads; ++i) impl_->threads.emplace_back([this] { impl_->work(); });
}

EncodePool::~EncodePool() {
    {
        const std::lock_guard lock(impl_->mutex);
        impl_->stopping = true;
    }
    impl_->wake.notify_all();
    for (auto& thread : impl_->threads) thread.join();
}

void EncodePool::post(SessionId session, std::function<void()> work) {
    const std::lock_guard lock(impl_->mutex);
    auto& queue = impl_->waiting[session];
    queue.push_back(std::move(work));
    if (queue.size() > 1) return;
    impl_->ready.push_back(session);
    impl_->wake.notify_one();
}

}  // namespace mote::server
