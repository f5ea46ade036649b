// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a Connection is made of beside its line: values, which their owner guards.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::client {

/// Callbacks on their way from the I/O thread to the owner's, in order. News of a state (a job, the
/// catalogue) has a key; newer news of the same key takes the older one's place at the end, so that an owner
/// who seldom looks costs bounded memory.
class Inbox {
  public:
    using Callback = std::function<void()>;

    /// An empty key: kept whatever comes later.
    void push(std::string key, Callback callback) {
        if (!key.empty()) {
            std::erase_if(entries_, [&](const Entry& entry) { return entry.key == key; });
        }
        entries_.push_back({std::move(key), std::move(callback)});
    }
    bool empty() const { return entries_.empty(); }

    struct Entry {
        std::string key;
        Callback callback;
    };
    std::deque<Entry> takeAll() { return std::exchange(entries_, {}); }

  private:
    std::deque<Entry> entries_;
};

/// How much of something came a second, over the last two seconds.
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

/// A code that is not known here becomes internal; an empty sentence is filled.
Error toError(const proto::Failure& failure);

/// A frame with all of its payload.
struct WholeFrame {
    proto::Frame message;
    std::vector<std::uint8_t> payload;
};

/// The pieces of a frame become the frame again. The server may leave a frame unfinished and go on with
/// another.
class FrameAssembly {
  public:
    /// Returns nothing while pieces are missing. Errors: corrupt (a piece of no frame, or of another place in
    /// it).
    Result<std::optional<WholeFrame>> add(proto::Frame message, std::vector<std::uint8_t> payload);

  private:
    std::optional<WholeFrame> open_;
};

}  // namespace mote::client
