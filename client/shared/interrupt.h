// SPDX-License-Identifier: GPL-3.0-or-later
//
// Interrupt: a wish to stop (SIGINT, SIGTERM, SIGHUP) that is asked for instead of breaking in. Made first
// thing by the main thread, so that every later thread leaves these signals alone; main thread only.
#pragma once

#include <csignal>

namespace mote::client {

class Interrupt {
  public:
    /// Blocks the signals. Also ignores SIGPIPE and SIGXFSZ, which writes report as errors. Throws
    /// std::system_error.
    Interrupt();
    ~Interrupt();
    Interrupt(const Interrupt&) = delete;
    Interrupt& operator=(const Interrupt&) = delete;

    /// Whether a signal has arrived by now.
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

}  // namespace mote::client
