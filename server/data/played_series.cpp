// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/played_series.h"

#include <algorithm>
#include <cstdlib>

namespace mote::server {

bool PlayOrder::asked(std::uint32_t step) {
    const std::int64_t now = step;
    if (now == last_) return false;
    if (last_ >= 0) {
        before_ = latest_;
        latest_ = now - last_;
        // The way round the end is the shorter one.
        if (latest_ > steps_ / 2) latest_ -= steps_;
        if (latest_ < -(steps_ / 2)) latest_ += steps_;
    }
    last_ = now;
    return true;
}

/// A single stride is an order if it leads to the neighbour. Two of one direction are: the shorter counts,
/// for a server that is slower than its client is asked for some steps only.
std::int64_t PlayOrder::stride() const {
    const bool oneWay = latest_ * before_ > 0;
    if (oneWay) return std::abs(latest_) < std::abs(before_) ? latest_ : before_;
    return std::abs(latest_) == 1 ? latest_ : 0;
}

std::vector<std::uint32_t> PlayOrder::next(std::size_t most) const {
    std::vector<std::uint32_t> steps;
    const std::int64_t by = stride();
    if (by == 0) return steps;
    std::int64_t at = last_;
    while (steps.size() < most) {
        at = ((at + by) % steps_ + steps_) % steps_;
        const auto step = static_cast<std::uint32_t>(at);
        if (at == last_ || std::find(steps.begin(), steps.end(), step) != steps.end()) break;
        steps.push_back(step);
    }
    return steps;
}

}  // namespace mote::server
