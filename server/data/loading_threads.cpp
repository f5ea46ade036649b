// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/loading_threads.h"

#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

namespace mote::server {
namespace {

constexpr int niceness = 10;

/// The calling thread gets about a tenth of what one gets that draws. If that is refused, they are equals.
/// On Linux both concern this thread alone, whatever it inherits.
void giveWay() {
    const sched_param none{};
    ::sched_setscheduler(0, SCHED_BATCH, &none);
    ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), niceness);
}

}  // namespace

LoadingThreads::LoadingThreads(unsigned threads, std::function<bool()> loadOne)
    : loadOne_(std::move(loadOne)) {
    for (unsigned i = 0; i < std::max(1U, threads); ++i) {
        threads_.emplace_back([this] {
            giveWay();
            run();
        });
    }
}

void LoadingThreads::stop() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    wake_.notify_all();
    for (auto& thread : threads_) thread.join();
    threads_.clear();
}

void LoadingThreads::wake() {
    {
        const std::lock_guard lock(mutex_);
        ++wakes_;
    }
    wake_.notify_all();
}

void LoadingThreads::run() {
    std::unique_lock lock(mutex_);
    while (!stopping_) {
        const auto seen = wakes_;
        lock.unlock();
        const bool loaded = loadOne_();
        lock.lock();
        if (!loaded) wake_.wait(lock, [&] { return stopping_ || wakes_ != seen; });
    }
}

}  // namespace mote::server
