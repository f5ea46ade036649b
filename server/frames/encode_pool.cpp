// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/frames/encode_pool.h"

#include <sys/resource.h>

#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

namespace mote::server {

namespace {

// Steps below the other threads' priority. Not more: they share locks with it, of memory and of queues, and
// would wait for a thread that holds one and is never let run.
constexpr int niceness = 5;

/// The work of some sessions, and the threads that share it. Its members are guarded by the pool's mutex.
struct Lane {
    std::condition_variable wake;
    std::map<SessionId, std::deque<std::function<void()>>> waiting;  // of sessions with work, at least one
    std::deque<SessionId> ready;  // sessions with work that no thread is on
    std::vector<std::thread> threads;

    void post(SessionId session, std::function<void()> work) {
        auto& queue = waiting[session];
        queue.push_back(std::move(work));
        if (queue.size() > 1) return;
        ready.push_back(session);
        wake.notify_one();
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

}  // namespace

struct EncodePool::Impl {
    std::mutex mutex;
    bool stopping = false;
    Lane foreground, background;

    void work(Lane& lane) {
        std::unique_lock lock(mutex);
        for (;;) {
            lane.wake.wait(lock, [&] { return stopping || !lane.ready.empty(); });
            if (stopping) return;
            const SessionId session = lane.ready.front();
            lane.ready.pop_front();
            auto task = std::move(lane.waiting[session].front());
            lock.unlock();
            task();
            task = nullptr;  // its picture goes before we wait
            lock.lock();
            lane.finished(session);
        }
    }

    /// On Linux a priority is a thread's own.
    void workNicely() {
        ::setpriority(PRIO_PROCESS, 0, ::getpriority(PRIO_PROCESS, 0) + niceness);
        work(background);
    }
};

EncodePool::EncodePool(unsigned threads) : impl_(std::make_unique<Impl>()) {
    for (unsigned i = 0; i < threads; ++i) {
        impl_->foreground.threads.emplace_back([this] { impl_->work(impl_->foreground); });
    }
}

EncodePool::~EncodePool() {
    {
        const std::lock_guard lock(impl_->mutex);
        impl_->stopping = true;
    }
    for (auto* lane : {&impl_->foreground, &impl_->background}) {
        lane->wake.notify_all();
        for (auto& thread : lane->threads) thread.join();
    }
}

void EncodePool::post(SessionId session, std::function<void()> work, bool background) {
    const std::lock_guard lock(impl_->mutex);
    auto& lane = background ? impl_->background : impl_->foreground;
    if (background && lane.threads.empty()) lane.threads.emplace_back([this] { impl_->workNicely(); });
    lane.post(session, std::move(work));
}

}  // namespace mote::server
