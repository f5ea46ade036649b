// SPDX-License-Identifier: GPL-3.0-or-later
//
// SlidingRate: how much of something came a second, over the last two seconds. A value; its owner guards it.
#pragma once

#include <chrono>
#include <deque>
#include <utility>

namespace mote::client {

class SlidingRate {
  public:
    using Time = std::chrono::steady_clock::time_point;
    static constexpr std::chrono::seconds window{2};

    void add(Time now, double amount) {
        forget(now);
        // Many small amounts at once share an entry, so that memory stays bounded.
        if (!entries_.empty() && now - entries_.back().first < window / 1000) {
            entries_.back().second += amount;
        } else {
            entries_.emplace_back(now, amount);
        }
    }

    double perSecond(Time now) {
        forget(now);
        double sum = 0.0;
        for (const auto& [time, amount] : entries_) sum += amount;
        return sum / std::chrono::duration<double>(window).count();
    }

  private:
    void forget(Time now) {
        while (!entries_.empty() && now - entries_.front().first > window) entries_.pop_front();
    }

    std::deque<std::pair<Time, double>> entries_;
};

}  // namespace mote::client
