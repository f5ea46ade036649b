// SPDX-License-Identifier: GPL-3.0-or-later
//
// Metrics: what the server counts while it works. Atomic numbers that any thread adds to without waiting for
// anybody; whoever serves them reads them whenever it is asked. Shared by the services of one server.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::server {

/// A number that only grows.
class Count {
  public:
    void add(std::uint64_t more = 1) { value_.fetch_add(more, std::memory_order_relaxed); }
    std::uint64_t value() const { return value_.load(std::memory_order_relaxed); }

  private:
    std::atomic<std::uint64_t> value_{0};
};

/// How many times were at most so long.
class TimeHistogram {
  public:
    /// Upper bounds of the buckets, in seconds; one more has none.
    static constexpr std::array bounds{0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1,
                                       0.2,   0.5,   1.0,   2.0,  5.0,  10.0, 60.0};

    void add(double milliseconds) {
        const double seconds = milliseconds / 1000.0;
        std::size_t bucket = 0;
        while (bucket < bounds.size() && seconds > bounds[bucket]) ++bucket;
        buckets_[bucket].add();
        microseconds_.add(seconds > 0.0 ? static_cast<std::uint64_t>(seconds * 1e6) : 0);
    }
    std::uint64_t inBucket(std::size_t bucket) const { return buckets_[bucket].value(); }
    double sum() const { return static_cast<double>(microseconds_.value()) * 1e-6; }  ///< seconds

  private:
    std::array<Count, bounds.size() + 1> buckets_;
    Count microseconds_;
};

struct Metrics {
    static constexpr std::size_t errorCodes = static_cast<std::size_t>(ErrorCode::internal) + 1;

    Count sessions;        ///< that said hello with the right token
    Count refusedFull;     ///< clients that were one too many
    Count refusedStartup;  ///< connections without a token that were dropped, as there were too many
    Count refusedToken;    ///< without the right token
    Count framesMoving;    ///< sent, of views in motion and on the way to the exact picture
    Count framesFinal;     ///< sent, exact
    Count bytesSent;       ///< to clients, without framing and encryption
    /// Of frames that were sent: waiting for their turn, planning, drawing, encoding, and from the view's
    /// arrival to the socket.
    TimeHistogram queued, plan, render, encode, total;
    std::array<Count, errorCodes> errors;  ///< failures that clients were told, by code

    /// A message and so many bytes after it went to a client.
    void countSent(const proto::ServerMessage& message, std::size_t payload);
};

}  // namespace mote::server
