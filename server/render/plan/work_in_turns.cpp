// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/work_in_turns.h"

#include <tbb/parallel_invoke.h>

#include <condition_variable>
#include <exception>
#include <mutex>
#include <system_error>
#include <utility>

namespace mote::render {
namespace {

using Clock = std::chrono::steady_clock;

/// Of work that nobody wants any more. No std::exception: nobody on its way takes it for an error.
struct GivenUp {};

/// Of the work that this thread does in turns; null on all others.
thread_local WorkInTurns::Gate* mine = nullptr;

std::exception_ptr failureOf(const std::function<void()>& work) {
    try {
        work();
        return {};
    } catch (...) {
        return std::current_exception();
    }
}

}  // namespace

/// Who goes on is counted: the owner waits until nobody does. All but isOver() and others() under the mutex;
/// what these read changes only while nobody goes on.
class WorkInTurns::Gate {
  public:
    /// Where a thread waits for one that it began.
    struct Fork {
        bool ended = false, awaited = false;
    };

    explicit Gate(Duration least) : least_(least) {}

    // The owner's.
    bool turn(const std::stop_token& pause) {
        std::unique_lock lock(mutex_);
        begun_ = Clock::now();
        if (ended_ != Clock::time_point()) others_ += begun_ - ended_;
        pause_ = pause;
        if (step_ == nullptr) resume();
        for (;;) {
            halted_.wait(lock, [this] { return running_ == 0; });
            if (step_ == nullptr || !takeStep(lock)) break;
            resume();
        }
        ended_ = Clock::now();
        if (failure_) std::rethrow_exception(failure_);
        return done_;
    }
    void giveUp() {
        const std::lock_guard lock(mutex_);
        givenUp_ = true;
        wake_.notify_all();
    }

    // The work's.
    void begin() {
        std::unique_lock lock(mutex_);
        wake_.wait(lock, [this] { return turns_ > 0 || givenUp_; });
        if (givenUp_) throw GivenUp();
    }
    void end(std::exception_ptr failure) {
        const std::lock_guard lock(mutex_);
        done_ = true;
        failure_ = std::move(failure);
        halt();
    }
    bool isOver() const { return pause_.stop_requested() && Clock::now() - begun_ >= least_; }
    Duration others() const { return others_; }
    void giveWay() {
        if (!isOver()) return;
        std::unique_lock lock(mutex_);
        wait(lock);
    }
    void await(const OwnersStep& step) {
        std::unique_lock lock(mutex_);
        step_ = &step;
        wait(lock);
        if (stepFailure_) std::rethrow_exception(std::exchange(stepFailure_, nullptr));
    }
    void fork() {
        const std::lock_guard lock(mutex_);
        ++running_;
    }
    void end(Fork& fork) {
        const std::lock_guard lock(mutex_);
        fork.ended = true;
        // Who waits for it goes on in its place.
        if (!fork.awaited) halt();
    }
    void join(Fork& fork, std::thread& thread) {
        {
            const std::lock_guard lock(mutex_);
            fork.awaited = !fork.ended;
            if (fork.awaited) halt();
        }
        thread.join();
    }

  private:
    /// One less goes on.
    void halt() {
        --running_;
        halted_.notify_all();
    }
    void resume() {
        running_ += std::exchange(waiting_, 0);
        step_ = nullptr;
        ++turns_;
        wake_.notify_all();
    }
    void wait(std::unique_lock<std::mutex>& lock) {
        ++waiting_;
        halt();
        wake_.wait(lock, [this, turn = turns_] { return turns_ != turn || givenUp_; });
        if (givenUp_) throw GivenUp();
    }
    bool takeStep(std::unique_lock<std::mutex>& lock) {
        lock.unlock();
        bool taken = true;
        auto failure = failureOf([&] { taken = (*step_)(pause_); });
        lock.lock();
        stepFailure_ = std::move(failure);
        return taken;
    }

    const Duration least_;
    std::stop_token pause_;
    Clock::time_point begun_, ended_;  // the turn
    Duration others_{0};

    std::mutex mutex_;
    std::condition_variable wake_, halted_;
    int running_ = 0, waiting_ = 1;  // threads: the first one waits for its first turn
    unsigned turns_ = 0;
    const OwnersStep* step_ = nullptr;  // that a thread waits for
    std::exception_ptr stepFailure_, failure_;
    bool done_ = false, givenUp_ = false;
};

WorkInTurns::WorkInTurns(std::function<void()> work, Duration least)
    : work_(std::move(work)), gate_(std::make_unique<Gate>(least)) {}

WorkInTurns::~WorkInTurns() {
    if (!thread_.joinable()) return;
    gate_->giveUp();
    thread_.join();
}

bool WorkInTurns::advance(const std::stop_token& pause) {
    if (!thread_.joinable() && !begin()) {
        work_();
        return true;
    }
    return gate_->turn(pause);
}

bool WorkInTurns::begin() {
    try {
        thread_ = std::thread([this] { run(); });
        return true;
    } catch (const std::system_error&) {
        return false;
    }
}

void WorkInTurns::run() {
    mine = gate_.get();
    gate_->end(failureOf([this] {
        gate_->begin();
        work_();
    }));
}

void giveWay() {
    if (mine != nullptr) mine->giveWay();
}

bool isStopped(const std::stop_token& stop) {
    giveWay();
    return stop.stop_requested();
}

WorkInTurns::Duration timeOfOthers() {
    return mine != nullptr ? mine->others() : WorkInTurns::Duration(0);
}

bool byOwner(const OwnersStep& step, const std::stop_token& pause) {
    if (mine == nullptr) return step(pause);
    mine->await(step);
    return true;
}

void bothInTurns(const std::function<void()>& one, const std::function<void()>& other) {
    auto* const gate = mine;
    if (gate == nullptr) return tbb::parallel_invoke(one, other);
    WorkInTurns::Gate::Fork fork;
    std::exception_ptr failure;
    gate->fork();
    std::thread helper;
    try {
        helper = std::thread([&] {
            mine = gate;
            failure = failureOf(one);
            gate->end(fork);
        });
    } catch (const std::exception&) {
        // There is no thread, or no memory, for it: the owner would wait for what is counted.
        gate->end(fork);
        one();
        return other();
    }
    const auto own = failureOf(other);
    gate->join(fork, helper);
    if (own) std::rethrow_exception(own);
    if (failure) std::rethrow_exception(failure);
}

Undisturbed::Undisturbed() : gate_(std::exchange(mine, nullptr)) {}

Undisturbed::~Undisturbed() {
    mine = gate_;
}

bool Undisturbed::isOver() const {
    return gate_->isOver();
}

void Undisturbed::giveWay() {
    gate_->giveWay();
}

}  // namespace mote::render
