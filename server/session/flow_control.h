// SPDX-License-Identifier: GPL-3.0-or-later
//
// FlowControl: how many frames of one client may be made, and how much of them may be sent, so that its link
// is busy and nothing queues in it. A frame is begun when the link is about to be through with those before
// it: what is shown is then as old as rendering and the link must make it. Clients that do not say what they
// receive have two credits instead. One owner, one thread; knows no clock.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "server/encode/frame_encoder.h"
#include "server/frames/view_task.h"

namespace mote::server {

/// LinkEstimator: what the link to one client carries, from when bytes were sent and when the client said
/// that it had them. A link is thought of as a pipe with a rate and a delay, in which bytes keep their order:
/// bytes begin to go through it when they reach it, or when those before them are through. So every receipt
/// is a measurement, busy link or idle one, and no traffic changes nothing. A value; knows no clock.
class LinkEstimator {
  public:
    void sent(Clock::time_point now, std::uint64_t bytes);
    /// All bytes that the client has received since the beginning. False where it claims more than was sent,
    /// or fewer than before.
    bool received(Clock::time_point now, std::uint64_t total);

    /// Bytes a second. Nothing before receipts of two times: those that come at once, as of a client that was
    /// busy, tell of no link. A link that is faster than what can be measured
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
    int times_ = 0;  // at which receipts came, those at once counted as one
    // Bytes and the time that the link took for them; older ones count less.
    double bytes_ = 0.0, seconds_ = 0.0;
    // The least round trip of this stretch of time and of the one before it.
    std::optional<Clock::duration> least_, leastBefore_;
    Clock::time_point stretchBegan_;
};

class FlowControl {
  public:
    /// `measured`: the client says what it receives; `credits`: those of its welcome.
    FlowControl(bool measured, std::uint32_t credits) : measured_(measured), credits_(credits) {}

    /// How many more frames may be begun now; they are counted as begun.
    std::uint32_t begin(Clock::time_point now);
    /// When begin() or piece() may allow more although nothing else happens; nothing: never.
    std::optional<Clock::time_point> due(Clock::time_point now) const;

    /// A frame that was begun is ready. `workMs`: from its plan to its payload; `quick`: others like it
    /// follow.
    void made(std::size_t bytes, double workMs, bool quick);
    /// One that was made is not sent, or not to its end.
    void dropped(bool partlySent);
    /// How many bytes of a frame may be sent now: of the `left` ones, from `begin` on. A frame that can wait
    /// goes in pieces, between which a newer one can overtake it. 0: later.
    std::size_t piece(Clock::time_point now, std::size_t begin, std::size_t left, bool canWait) const;
    /// A piece of a frame is sent: whether it is the first or the last one.
    void sent(Clock::time_point now, std::size_t bytes, bool first, bool last);

    /// Errors: invalidArgument where the client returns or has received what was not sent; names the field.
    Status returned(Clock::time_point now, const proto::Credit& credit);

    /// What a frame in motion may hold; nothing while nothing is known.
    std::optional<std::size_t> frameBytes() const;
    const LinkEstimator& link() const { return link_; }

  private:
    bool mayBegin(Clock::time_point now) const;
    Clock::duration linkTime(double bytes) const;
    double mostInFlight() const;

    const bool measured_;
    const std::uint32_t credits_;
    std::uint32_t begun_ = 0;         ///< frames that are made now, or may be
    std::uint32_t waiting_ = 0;       ///< made, nothing of them sent
    std::uint32_t outstanding_ = 0;   ///< sent at least in part, not returned
    std::deque<std::uint64_t> ends_;  ///< bytes sent up to the last one of each frame in flight
    std::uint64_t sentBytes_ = 0;
    double meanBytes_ = 0.0;  ///< of late frames in motion
    double workMs_ = 10.0;    ///< of late ones
    LinkEstimator link_;
};

}  // namespace mote::server
