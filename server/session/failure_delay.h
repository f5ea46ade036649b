// SPDX-License-Identifier: GPL-3.0-or-later
//
// FailureDelay: how long the answer to a wrong token waits: the longer, the more there were lately, from
// whomever. The right token never waits. Owned by Startups; a value.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>

namespace mote::server {

class FailureDelay {
  public:
    using Time = std::chrono::steady_clock::time_point;

    static constexpr std::chrono::milliseconds first{25}, longest{2000};
    static constexpr double forgottenPerSecond = 1.0;

    explicit FailureDelay(std::chrono::milliseconds least = first, std::chrono::milliseconds most = longest)
        : least_(least), most_(most) {}

    /// For one more, at this time.
    std::chrono::milliseconds next(Time now) {
        const double passed = std::chrono::duration<double>(now - last_).count();
        recent_ = std::max(0.0, recent_ - forgottenPerSecond * passed);
        last_ = now;
        const double delay = static_cast<double>(least_.count()) * std::exp2(std::min(recent_, 16.0));
        recent_ += 1.0;
        return std::min(most_, std::chrono::milliseconds(static_cast<std::int64_t>(delay)));
    }

  private:
    std::chrono::milliseconds least_, most_;
    double recent_ = 0.0;
    Time last_{};
};

}  // namespace mote::server
