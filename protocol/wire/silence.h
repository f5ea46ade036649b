// SPDX-License-Identifier: GPL-3.0-or-later
//
// Silence: when the other side of a connection is asked whether it is still there, and when it counts as
// gone. It is looked at now and then, with the time and what has passed the connection so far; each end of a
// connection has one. A value.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace mote::wire {

class Silence {
  public:
    using Time = std::chrono::steady_clock::time_point;
    enum class Verdict { fine, ask, gone };

    /// `limit` 0: the other side may be silent for ever.
    Silence(std::chrono::milliseconds limit, Time now) : limit_(limit), since_(now), looked_(now) {}

    /// How often to look; 0: never.
    std::chrono::milliseconds interval() const {
        return limit_.count() == 0 ? limit_ : std::max(limit_ / 8, std::chrono::milliseconds(1));
    }

    /// `progress`: of the stream. Asks once in a silence, when half of it is over.
    Verdict at(Time now, std::uint64_t progress) {
        if (limit_.count() == 0) return Verdict::fine;
        // Who was stopped for a while has heard nothing for reasons of their own.
        const bool absent = now - looked_ > limit_ / 2;
        looked_ = now;
        if (absent || progress != progress_) {
            since_ = now;
            asked_ = false;
            progress_ = progress;
        }
        if (now - since_ >= limit_) return Verdict::gone;
        if (asked_ || now - since_ < limit_ / 2) return Verdict::fine;
        asked_ = true;
        return Verdict::ask;
    }

  private:
    std::chrono::milliseconds limit_;
    Time since_, looked_;
    std::uint64_t progress_ = 0;
    bool asked_ = false;
};

}  // namespace mote::wire
