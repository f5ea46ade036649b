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

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "server/encode/encoding_choice.h"
#include "server/session/link_estimator.h"

namespace mote::server {

class FlowControl {
  public:
    /// `measured`: the client says what it receives; `credits`: those of its welcome.
    FlowControl(bool measured, std::uint32_t credits) : measured_(measured), credits_(credits) {}

    /// How many more frames may be begun now; they are counted as begun.
    std::uint32_t begin(Clock::time_point now);
    /// When begin() or piece() may allow more although nothing else happens; nothing: never.
    std::optional<Clock::time_point> due(Clock::time_point now) const;

    /// A frame that was begun is ready. `workMs`: from its plan to its payload; `quick`: of a hand in motion.
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
