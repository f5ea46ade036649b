// SPDX-License-Identifier: GPL-3.0-or-later
//
// LinkEstimator: what the link to one client carries, from when bytes were sent and when the client said that
// it had them. A link is thought of as a pipe with a rate and a delay, in which bytes keep their order: bytes
// begin to go through it when they reach it, or when those before them are through. So every receipt is a
// measurement, busy link or idle one, and no traffic changes nothing. A value; knows no clock.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "server/frames/view_task.h"

namespace mote::server {

class LinkEstimator {
  public:
    void sent(Clock::time_point now, std::uint64_t bytes);
    /// All bytes that the client has received since the beginning. False where it claims more than was sent,
    /// or fewer than before.
    bool received(Clock::time_point now, std::uint64_t total);

    /// Bytes a second. Nothing before the first receipts. A link that is faster than what can be measured
    /// here seems endless, and that is all that matters.
    std::optional<double> rate() const;
    /// The shortest time of late between sending and receipt of anything: both ways without a queue. Nothing
    /// before the first receipt.
    std::optional<Clock::duration> roundTrip() const;
    /// Bytes that were sent and not yet received.
    std::uint64_t inFlight() const { return sent_ - received_; }
    /// When the link will have carried what was sent; at once where it is not measured.
    Clock::time_point idleAt() const { return idleAt_; }

  private:
    struct Piece {
        std::uint64_t end;  ///< bytes sent up to its last one
        Clock::time_point sent;
    };

    void learnRoundTrip(Clock::time_point now, Clock::duration sample);
    void learnRate(std::uint64_t bytes, Clock::duration busy);

    std::deque<Piece> pieces_;  // in flight
    std::uint64_t sent_ = 0, received_ = 0;
    Clock::time_point lastReceipt_, idleAt_;
    // Bytes and the time that the link took for them; older ones count less.
    double bytes_ = 0.0, seconds_ = 0.0;
    // The least round trip of this stretch of time and of the one before it.
    std::optional<Clock::duration> least_, leastBefore_;
    Clock::time_point stretchBegan_;
};

}  // namespace mote::server
