// SPDX-License-Identifier: GPL-3.0-or-later
//
// LineLimit: how many lines of each kind are written in a window of time. It knows no clock: its owner locks
// it and tells it the time.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace mote::server::log {

class LineLimit {
  public:
    using Clock = std::chrono::steady_clock;
    /// Lines of a kind that were not written.
    struct LeftOut {
        std::string kind;
        std::uint64_t count = 0;
    };

    LineLimit(unsigned lines, Clock::duration window) : lines_(lines), window_(window) {}

    /// Whether a line of this kind is written now.
    bool admit(std::string_view kind, Clock::time_point now);
    /// What was left out in windows that are over by `now`; each is told once.
    std::vector<LeftOut> over(Clock::time_point now);

  private:
    struct Window {
        Clock::time_point begin;
        std::uint64_t lines = 0;
    };

    unsigned lines_;
    Clock::duration window_;
    std::map<std::string, Window, std::less<>> windows_;  // as many as there are kinds: the sources' own
};

}  // namespace mote::server::log
