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

struct Work {
    std::function<void()> run;
    EncodePool::Pace pace;
};

/// Threads, and what they share: sessions whose next work is theirs. Its members are guarded by the pool's
/// mutex.
struct Lane {
    std::condition_variable wake;
    std::deque<SessionId> ready;  // that no thread is on
    std::vector<std::thread> threads;
};

}  // namespace

struct EncodePool::Impl {
    std::mutex mutex;
    bool stopping = false;
    std::map<SessionId, std::deque<Work>> waiting;  // of sessions with work, at least one
    Lane quick, slow;

    Lane& laneOf(const Work& work) { return work.pace == Pace::slow ? slow : quick; }

    void post(SessionId session, Work work) {
        auto& queue = waiting[session];
        queue.push_back(std::move(work));
        if (queue.size() == 1) makeReady(session, queue);
    }

    void makeReady(SessionId session, const std::deque<Work>& queue) {
        Lane& lane = laneOf(queue.front());
        lane.ready.push_back(session);
        lane.wake.notify_one();
    }

    /// A session stays in `waiting` while a thread is on it, so that nobody else takes its next piece.
    void finished(SessionId session) {
        auto& queue = waiting[session];
        queue.pop_front();
        if (queue.empty()) {
            waiting.erase(session);
        } else {
            makeReady(session, queue);
        }
    }

    void work(Lane& lane) {
        std::unique_lock lock(mutex);
        for (;;) {
            lane.wake.wait(lock, [&] { return stopping || !lane.ready.empty(); });
            if (stopping) return;
            const SessionId session = lane.ready.front();
            lane.ready.pop_front();
            auto task = std::move(waiting[session].front().run);
            lock.unlock();
            task();
            task = nullptr;  // its picture goes before we wait
            lock.lock();
            finished(session);
        }
    }

    /// On Linux a priority is a thread's own.
    void workNicely() {
        ::setpriority(PRIO_PROCESS, 0, ::getpriority(PRIO_PROCESS, 0) + niceness);
        work(slow);
    }
};

EncodePool::EncodePool(unsigned threads) : impl_(std::make_unique<Impl>()) {
    for (unsigned i = 0; i < threads; ++i) {
        impl_->quick.threads.emplace_back([this] { impl_->work(impl_->quick); });
    }
}

EncodePool::~EncodePool() {
    {
        const std::lock_guard lock(impl_->mutex);
        impl_->stopping = true;
    }
    for (auto* lane : {&impl_->quick, &impl_->slow}) {
        lane->wake.notify_all();
        for (auto& thread : lane->threads) thread.join();
    }
}

void EncodePool::post(SessionId session, std::function<void()> work, Pace pace) {
    const std::lock_guard lock(impl_->mutex);
    if (pace == Pace::slow && impl_->slow.threads.empty())
        impl_->slow.threads.emplace_back([this] { impl_->workNicely(); });
    impl_->post(session, {std::move(work), pace});
}

}  // namespace mote::server
