// SPDX-License-Identifier: GPL-3.0-or-later
//
// Interrupt: a wish to stop (SIGINT, SIGTERM, SIGHUP) that is asked for instead of breaking in. Made first
// thing by the main thread, so that every later thread leaves these signals alone; main thread only.
#pragma once

#include <chrono>
#include <condition_variable>
#include <csignal>
#include <exception>
#include <mutex>
#include <variant>

#include "protocol/base/complain.h"
#include "protocol/base/error.h"

namespace mote::client {

class Interrupt {
  public:
    /// Blocks the signals. Also ignores SIGPIPE and SIGXFSZ, which writes report as errors. Throws
    /// std::system_error.
    Interrupt();
    /// Signals break in again; SIGPIPE and SIGXFSZ stay ignored.
    ~Interrupt();
    Interrupt(const Interrupt&) = delete;
    Interrupt& operator=(const Interrupt&) = delete;

    /// Tells whether a signal has arrived by now.
    bool requested() const;
    /// Its number; 0 before.
    int signal() const { return signal_; }
    /// Becomes readable when one arrives, for poll().
    int descriptor() const { return descriptor_; }

    /// What a child process must be given back between fork and exec; safe to call there.
    void restoreInChild() const;

  private:
    int descriptor_ = -1;
    mutable int signal_ = 0;
    sigset_t before_{};
};

/// Wakes the main thread when a server or a thread of ours has something for it. Any thread calls it;
/// one waits.
class Wakeup {
  public:
    void operator()() {
        {
            const std::lock_guard lock(mutex_);
            due_ = true;
        }
        changed_.notify_one();
    }

    /// Waits until it was called since the last wait, at most so long.
    void wait(std::chrono::milliseconds most) {
        std::unique_lock lock(mutex_);
        changed_.wait_for(lock, most, [&] { return due_; });
        due_ = false;
    }

  private:
    std::mutex mutex_;
    std::condition_variable changed_;
    bool due_ = false;
};

/// The whole of a program `name`: `parse` gives its options, or the exit status after help or a mistake, and
/// `work` does what they say. Returns 0, 1 after an error that it tells, or 128 and the signal's number, as
/// shells say it. Main thread, first thing.
template <class Options>
int runProgram(const char* name, std::variant<Options, int> (*parse)(int, const char* const*),
               Status (*work)(const Options&, const Interrupt&), int argc, const char* const* argv) {
    try {
        const Interrupt interrupt;
        const auto parsed = parse(argc, argv);
        if (const int* status = std::get_if<int>(&parsed)) return *status;
        const auto done = work(std::get<Options>(parsed), interrupt);
        if (done.ok()) return 0;
        complain(name, done.error().toString());
        return interrupt.requested() ? 128 + interrupt.signal() : 1;
    } catch (const std::exception& error) {
        complainAtEnd(name, error);
        return 1;
    }
}

}  // namespace mote::client
