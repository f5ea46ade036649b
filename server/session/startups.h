// SPDX-License-Identifier: GPL-3.0-or-later
//
// Startups: the connections that have not shown a token yet. They are counted apart from the sessions; the
// more there are, the more likely one of them, or the newcomer, is dropped at random for each that comes, so
// that who fills all places and renews them for ever keeps nobody out who shows a token soon. Owned by the
// server, one thread.
//
// As MaxStartups of sshd_config(5), but that not always the newcomer goes: whoever is already there would
// else keep the place until the deadline.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "server/metrics/metrics.h"
#include "server/session/failure_delay.h"
#include "server/session/handshake.h"
#include "server/session/startup_limits.h"

namespace mote::server {

class Startups {
  public:
    using Random = StartupRandom;

    /// `terms`: all but wrongToken and ended, which are filled here. `metrics` outlive it.
    Startups(StartupLimits limits, Random random, FailureDelay delay, HandshakeTerms terms, Metrics& metrics);
    ~Startups() { stop(); }
    Startups(const Startups&) = delete;
    Startups& operator=(const Startups&) = delete;

    void add(wire::MessageStream stream);
    /// Whether there are so many that somebody may be dropped.
    bool crowded() const { return pending_.size() >= limits_.start; }
    std::size_t pending() const { return pending_.size(); }
    /// Ends them all.
    void stop();

  private:
    /// Whether it was the newcomer, who is there no more then.
    bool dropOne(wire::MessageStream& newcomer);
    void erase(const Handshake& handshake);

    StartupLimits limits_;
    Random random_;
    HandshakeTerms terms_;
    Metrics& metrics_;
    FailureDelay delay_;
    std::vector<std::shared_ptr<Handshake>> pending_;
};

}  // namespace mote::server
