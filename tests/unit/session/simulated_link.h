// SPDX-License-Identifier: GPL-3.0-or-later
//
// SimulatedLink: a pipe with a rate and a delay, and a client at its end that says what it received; time is
// a number. A value.
#pragma once

#include <algorithm>
#include <deque>
#include <optional>

#include "server/frames/view_task.h"

namespace mote::test {

struct SimulatedLink {
    using Time = server::Clock::time_point;

    SimulatedLink() = default;
    SimulatedLink(double rate, server::Clock::duration delay) : bytesPerSecond(rate), oneWay(delay) {}

    double bytesPerSecond = 2.5e6;
    server::Clock::duration oneWay = std::chrono::milliseconds(50);

    /// A receipt on its way back.
    struct Receipt {
        Time sent, arrives;
        std::uint64_t total;  ///< bytes received so far
    };

    /// Returns how many bytes wait for the rate, these included.
    double send(Time now, std::uint64_t bytes) {
        const std::chrono::duration<double> takes(static_cast<double>(bytes) / bytesPerSecond);
        idle_ = std::max(idle_, now + oneWay) + std::chrono::duration_cast<server::Clock::duration>(takes);
        total_ += bytes;
        receipts_.push_back({now, idle_ + oneWay, total_});
        return std::chrono::duration<double>(idle_ - now - oneWay).count() * bytesPerSecond;
    }
    /// The next receipt that has arrived.
    std::optional<Receipt> next(Time now) {
        if (receipts_.empty() || receipts_.front().arrives > now) return std::nullopt;
        const auto receipt = receipts_.front();
        receipts_.pop_front();
        return receipt;
    }
    std::optional<Time> nextArrival() const {
        return receipts_.empty() ? std::nullopt : std::optional(receipts_.front().arrives);
    }

  private:
    Time idle_;
    std::uint64_t total_ = 0;
    std::deque<Receipt> receipts_;
};

}  // namespace mote::test
