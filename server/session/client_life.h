// SPDX-License-Identifier: GPL-3.0-or-later
//
// ClientLife: whether a client is still there, and still wants something. Owned by its session, which looks
// now and then. A value; knows no clock.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/wire/silence.h"
#include "server/frames/view_task.h"

namespace mote::server {

class ClientLife {
  public:
    using Milliseconds = std::chrono::milliseconds;

    /// What a look finds.
    struct Finding {
        bool ask = false;               ///< it is to be asked whether it is there
        std::optional<Error> end = {};  ///< why its session ends
    };

    /// Nobody is asked and nothing ends.
    ClientLife() = default;
    /// `silence` of a client and `idle` without a wish that end a session; 0: none does. An older client does
    /// not know our pings, and one in the background waits as long as others work.
    ClientLife(const proto::Hello& hello, Milliseconds silence, Milliseconds idle, Clock::time_point now);

    /// How often to look; 0: never.
    Milliseconds interval() const;
    /// `progress`: of the stream.
    Finding at(Clock::time_point now, std::uint64_t progress);
    /// Pings and what returns by itself are no wishes.
    void heard(const proto::ClientMessage& message, Clock::time_point now);
    /// Who is told what they wait for is not idle: the pictures of a film, the end of a job.
    void told(const proto::ServerMessage& message, Clock::time_point now);

  private:
    Milliseconds limit_{0}, idle_{0};
    wire::Silence silence_{Milliseconds(0), {}};
    Clock::time_point lastWish_;
};

}  // namespace mote::server
